/// The output files of a run, written by ratslam_run. The nodes write those of trajectory_files.h.
///
///     trajectory_online.tum    poses as they were estimated at the time
///     pose_covariance.csv      the same poses at the decisions, with covariance: stamp,x,y,z,yaw, then the upper
///                              triangle row by row (experience_map.h: robotCovariance)
///     trajectory_final.tum     the path in the finished map
///     trajectory_odometry.tum  the odometry alone, if it has poses
///     odometry.csv             the odometry in the form of odometry_file.h; a run from this file is the same
///     map.yaml                 experiences and links
///     templates.csv            stamp,template_id,error,relative_rad: one line per view event; id -1: no view
///     actions.csv              stamp,action,src_id,dest_id,x,y,th: one line per decision; x, y, th [cells]
///     summary.json             counts, version, parameters, ms per frame of each module
///     pose_cells.csv           activity of the pose cells at a few moments (pose_cell_snapshots.h)
///     pose_cells.npz           the same at regular numbers of views, if asked for (pose_cell_recording.h)
///
/// All files are written under temporary names and renamed together at the end. After a run that was killed, or ran out
/// of disk, the files of an earlier run remain. A run that ends removes those that it does not replace.
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

/// Converts poses of the map to poses in space, with the attitude from the odometry.
std::vector<StampedPose3> toPoses3(const std::vector<StampedPose>& trajectory);

class RunLog {
 public:
  /// Makes the folder. @throws std::runtime_error naming what finish() could not write
  explicit RunLog(const std::string& folder);

  /// Whether a run writes, or removes, a file of this name in its folder.
  static bool writes(const std::string& name);

  /// @param map  state of the map after `progress`
  void append(const Pipeline::Progress& progress, const ExperienceMap& map);

  /// Saves everything that the files depend on: so a continued run leaves the files of one whole run.
  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing
  void load(const State& state);

  /// Writes trajectories, map and summary.
  /// @param counts  counters of the runner (frames, corrupt images, ...), by name
  /// @param decoding_seconds  time spent on decoding images
  /// @param snapshots  of the pose cells, or null
  /// @param cells  recording of the pose cells, or null
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
