/// Reading of a node's parameters.
///
/// The first argument may name a configuration file (OpenRatSLAM's ini, or YAML). Private ROS parameters override it. A
/// key that no part of the system knows is an error, so that a misspelt key is noticed. Keys of the other nodes are
/// allowed, because all nodes share one configuration.
#pragma once

#include <ros/node_handle.h>

#include <string>

#include "ratslam/common/parameter_map.h"
#include "ratslam_ros/support/node_params.h"
#include "ratslam_ros/support/system_keys.h"

namespace ratslam {

/// @param argc,argv  after ros::init, which removes remappings
/// @throws std::exception with one clear line: unreadable file, unknown key, a group instead of a value
ParameterMap loadNodeParameters(int argc, const char* const* argv, const ros::NodeHandle& private_handle);

/// Values of a dictionary of the parameter server. @param ns its namespace, for naming origins
/// @throws std::invalid_argument for values that are neither scalars nor lists of scalars
ParameterMap parametersFromXmlRpc(XmlRpc::XmlRpcValue& dictionary, const std::string& ns);

/// Parameters of one part. @throws std::invalid_argument as ParameterMap::read does
template <class Params>
Params readParams(const ParameterMap& parameters) {
  Params params;
  parameters.read(params);
  return params;
}

/// Name of a topic below `topic_root`, relative unless the root is absolute.
/// @throws std::invalid_argument if the root cannot be part of a ROS name
std::string topicName(const std::string& topic_root, const std::string& name);

}  // namespace ratslam
