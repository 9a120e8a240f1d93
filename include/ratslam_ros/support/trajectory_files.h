/// The robot's path and the map as files for evaluation tools: FILE_online, FILE_final and FILE_map.yaml.
#pragma once

#include <string>

#include "ratslam/experience_map/experience_map.h"

namespace ratslam {

struct TrajectoryFiles {
  std::string online;
  std::string final;
  std::string map;
  std::string changes;  ///< written only if there were any
};

/// Names of the files. An ending .tum or .txt of `file` is removed, then _online or _final and the ending of the format
/// are added: .tum, or .txt for KITTI. runs/kitti.tum -> runs/kitti_online.tum, runs/kitti_final.tum,
/// runs/kitti_map.yaml and runs/kitti_changes.csv
TrajectoryFiles trajectoryFiles(const std::string& file, const std::string& format);

/// Fails at once if writeTrajectories would fail at the end of a long run. Does nothing if `file` is empty.
/// @throws std::runtime_error naming the file that cannot be written
void requireTrajectoriesWritable(const std::string& file, const std::string& format);

/// Writes all files or none, and creates the folder if it is missing. If time went back, trajectories with stamps are
/// continued in further files (dataset/trajectory_io.h). @return the names of the files
/// @throws std::runtime_error naming what cannot be written
TrajectoryFiles writeTrajectories(const ExperienceMap& map, const std::string& file,
                                  const std::string& format);

/// Reports that the files were written. @param files  names   @param empty  nothing was mapped
void reportTrajectories(const std::string& files, bool empty);

}  // namespace ratslam
