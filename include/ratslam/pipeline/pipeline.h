/// The whole system without ROS: Fig. 1 of the paper as code.
///
///     image -> visual odometry -----------------+------------------+
///       |                                       v                  v
///       +----> local view cells -> view -> pose cells -> action -> experience map
///
/// The nodes run one model each over topics; this runs them in one process. Both use the same stages and give
/// the same map to the last bit.
#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>

#include "ratslam/config/parameter_map.h"
#include "ratslam/local_view/local_view_cells.h"
#include "ratslam/pipeline/map_stage.h"
#include "ratslam/pipeline/pose_cell_stage.h"
#include "ratslam/visual_odometry/profile_odometry.h"

namespace ratslam {

struct PipelineParams {
  LocalViewParams local_view;
  PoseCellParams pose_cells;
  ExperienceMapParams experience_map;
  ProfileOdometryParams profile_odometry;

  /// @throws std::invalid_argument for bad values and for keys that no module knows
  static PipelineParams fromMap(const ParameterMap& map);
  /// Keys of all modules and of general settings: what a shared configuration file may contain.
  static std::set<std::string> knownKeys();
};

}  // namespace ratslam
