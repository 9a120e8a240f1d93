/// Keys of all parameters of the system: those of the models and those of the nodes. All programs share one
/// configuration, so the offline runner also accepts the nodes' keys. This header needs no ROS, because the runner can be
/// built without it.
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
