/// The robot's path as files: FILE_online and FILE_final, for evaluation tools.
#pragma once

#include <string>

#include "ratslam/experience_map/experience_map.h"

namespace ratslam {

struct TrajectoryFiles {
  std::string online;
  std::string final;
};

/// Names of the two files: an ending .tum or .txt of `file` is taken off, then _online or _final and the
/// ending of the format - .tum or, for KITTI, .txt - are added. runs/kitti.tum -> runs/kitti_online.tum,
/// runs/kitti_final.tum
TrajectoryFiles trajectoryFiles(const std::string& file, const std::string& format);

/// Writes both, making the folder where it is missing. @return their names
/// @throws std::runtime_error naming what cannot be written
TrajectoryFiles writeTrajectories(const ExperienceMap& map, const std::string& file,
                                  const std::string& format);

}  // namespace ratslam
