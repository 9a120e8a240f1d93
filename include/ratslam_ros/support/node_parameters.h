/// Where a node's parameters come from, and that nothing in them goes unnoticed.
///
/// A configuration file (OpenRatSLAM's ini, or YAML) may be named as the first argument; private ROS
/// parameters override it. A key that no part of the system knows is an error, so that a misspelt one never
/// passes for a default; keys of the other nodes are fine, because all nodes share one configuration.
#pragma once

#include <ros/node_handle.h>

#include <string>

#include "ratslam/common/parameter_map.h"
#include "ratslam_ros/support/node_params.h"
#include "ratslam_ros/support/system_keys.h"

namespace ratslam {

/// @param argc,argv  as ros::init left them (remappings taken out)
/// @throws std::exception with one clear line: unreadable file, unknown key, a group where a value should be
ParameterMap loadNodeParameters(int argc, const char* const* argv, const ros::NodeHandle& private_handle);

/// Values of a dictionary of the parameter server; `ns` is where it hangs and serves to name origins.
/// @throws std::invalid_argument for values that are no scalar and no list of scalars
ParameterMap parametersFromXmlRpc(XmlRpc::XmlRpcValue& dictionary, const std::string& ns);

/// One part's parameters out of all of them. @throws std::invalid_argument as ParameterMap::read does
template <class Params>
Params readParams(const ParameterMap& parameters) {
  Params params;
  parameters.read(params);
  return params;
}

/// Name of a topic below `topic_root`, relative unless the root is absolute.
/// @throws std::invalid_argument where the root cannot be part of a ROS name
std::string topicName(const std::string& topic_root, const std::string& name);

}  // namespace ratslam
