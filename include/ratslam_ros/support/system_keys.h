/// Every parameter that some part of the system understands: those of the models and those of the nodes. All
/// programs share one configuration, so the offline runner takes the nodes' keys too, also where it is built
/// without ROS: nothing here needs it.
#pragma once

#include <set>
#include <string>

#include "ratslam/system/pipeline.h"
#include "ratslam_ros/support/node_params.h"

namespace ratslam {

inline std::set<std::string> systemKeys() {
  std::set<std::string> keys = PipelineParams::knownKeys();
  keys.merge(keysOf<NodeParams>());
  return keys;
}

}  // namespace ratslam
