/// The robot's path and the map as files: FILE_online, FILE_final and FILE_map.yaml, for evaluation tools.
#pragma once

#include <string>

#include "ratslam/experience_map/experience_map.h"

namespace ratslam {

struct TrajectoryFiles {
  std::string online;
  std::string final;
  std::string map;
  std::string changes;  ///< where there were any
};

/// Names of the files: an ending .tum or .txt of `file` is taken off, then _online or _final and the
/// ending of the format - .tum or, for KITTI, .txt - are added. runs/kitti.tum -> runs/kitti_online.tum,
/// runs/kitti_final.tum, runs/kitti_map.yaml and runs/kitti_changes.csv
TrajectoryFiles trajectoryFiles(const std::string& file, const std::string& format);

/// Fails now where writeTrajectories would fail at the end of a long run; nothing where `file` is empty.
/// @throws std::runtime_error naming what cannot be written
void requireTrajectoriesWritable(const std::string& file, const std::string& format);

/// Writes them, making the folder where it is missing; all of them or none. Where time went back, trajectories with
/// stamps go on in files of their own (dataset/trajectory_io.h). @return their names
/// @throws std::runtime_error naming what cannot be written
TrajectoryFiles writeTrajectories(const ExperienceMap& map, const std::string& file,
                                  const std::string& format);

}  // namespace ratslam
