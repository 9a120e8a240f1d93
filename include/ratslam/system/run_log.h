/// The files that a run leaves, the same whether the nodes or the offline runner made it.
///
///     trajectory_online.tum  poses as they were known at the time
///     trajectory_final.tum   the path as the finished map sees it
///     trajectory_odometry.tum  the odometry alone, where it knows its pose
///     odometry.csv           the odometry as odometry_file.h reads it: a run that takes it from there is the
///                            same
///     map.yaml               experiences and links
///     templates.csv          stamp,template_id,error,relative_rad          a line a view event
///     actions.csv            stamp,action,src_id,dest_id,x,y,th            a line a decision, pose cells in
///     cells summary.json           counts, version, parameters, ms per frame of each module
#pragma once

#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/system/pipeline.h"

namespace ratslam {

/// Poses of the map as poses in space: level, at their height.
std::vector<StampedPose3> toPoses3(const std::vector<StampedPose>& trajectory);

class RunLog {
 public:
  /// Makes the folder and opens the files. @throws std::runtime_error naming what cannot be written
  explicit RunLog(const std::string& folder);

  void append(const Pipeline::Progress& progress);

  /// Writes trajectories, map and summary.
  /// @param counts  whatever the runner counted (frames, corrupt images, ...), by name
  /// @param decoding_seconds  spent on decoding images
  /// @throws std::runtime_error naming the file that cannot be written
  void finish(const Pipeline& pipeline, PipelineParams params, const std::map<std::string, double>& counts,
              double decoding_seconds = 0.0);

 private:
  std::string folder_;
  std::ofstream templates_;
  std::ofstream actions_;
  std::vector<OdometrySample> odometry_;
  std::size_t frames_ = 0;
};

}  // namespace ratslam
