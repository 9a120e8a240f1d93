/// The files that a run leaves, the same whether the nodes or the offline runner made it.
///
///     trajectory_online.tum  poses as they were known at the time
///     pose_covariance.csv    the same poses at the moments of decisions, with their covariance: stamp,x,y,z,yaw,
///                            then its upper triangle row by row (experience_map.h: robotCovariance)
///     trajectory_final.tum   the path as the finished map sees it
///     trajectory_odometry.tum  the odometry alone, where it knows its pose
///     odometry.csv           the odometry as odometry_file.h reads it: a run that takes it from there
///                            is the same
///     map.yaml               experiences and links
///     templates.csv          stamp,template_id,error,relative_rad          a line a view event; id -1: the image
///                            showed nothing
///     actions.csv            stamp,action,src_id,dest_id,x,y,th            a line a decision, pose cells in
///     cells summary.json           counts, version, parameters, ms per frame of each module
///     pose_cells.csv         activity of the pose cells at a few moments (pose_cell_snapshots.h)
///
/// All of them are written beside their places and put there together at the end: a run that was killed, or
/// ran out of disk, leaves what an earlier run left; one that ends leaves nothing of an earlier run.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "ratslam/common/atomic_file.h"
#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/system/pipeline.h"
#include "ratslam/system/pose_cell_recording.h"
#include "ratslam/system/pose_cell_snapshots.h"

namespace ratslam {

/// Poses of the map as poses in space, with the attitude that the odometry knows.
std::vector<StampedPose3> toPoses3(const std::vector<StampedPose>& trajectory);

class RunLog {
 public:
  /// Makes the folder. @throws std::runtime_error naming what finish() could not write
  explicit RunLog(const std::string& folder);

  /// Whether a run leaves, or takes away, a file of this name in its folder.
  static bool writes(const std::string& name);

  /// @param map  as it is after `progress`
  void append(const Pipeline::Progress& progress, const ExperienceMap& map);

  /// All that the files depend on, so that a run which is continued leaves what one run would have left.
  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing
  void load(const State& state);

  /// Writes trajectories, map and summary.
  /// @param counts  whatever the runner counted (frames, corrupt images, ...), by name
  /// @param decoding_seconds  spent on decoding images
  /// @param snapshots  of the pose cells, where some were taken
  /// @param cells  activity of the pose cells all along, where it was asked for
  /// @throws std::runtime_error naming the file that cannot be written
  void finish(const Pipeline& pipeline, PipelineParams params, const std::map<std::string, double>& counts,
              double decoding_seconds = 0.0, const PoseCellSnapshots* snapshots = nullptr,
              PoseCellRecording* cells = nullptr);

 private:
  std::string folder_;
  AtomicFile templates_;
  AtomicFile actions_;
  /// A line of actions.csv.
  struct Decision {
    TopologicalAction action;
    PoseCellEstimate estimate;

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("action", action);
      fields("estimate", estimate);
    }
  };

  /// A line of pose_covariance.csv.
  struct KnownPose {
    Stamp stamp = 0;
    MapPose pose;
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("pose", pose);
      fields("covariance", covariance);
    }
  };

  void write(const ViewEvent& view);
  void write(const Decision& decision);

  std::vector<ViewEvent> views_;
  std::vector<Decision> decisions_;
  std::vector<KnownPose> known_poses_;
  std::vector<OdometrySample> odometry_;
  std::size_t frames_ = 0;
};

}  // namespace ratslam
