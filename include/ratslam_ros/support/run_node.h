/// Main function of the nodes: parameters, spinning, and an orderly end.
#pragma once

#include <ros/ros.h>

#include <string>
#include <type_traits>
#include <utility>

#include "ratslam_ros/support/node_parameters.h"

namespace ratslam {

/// Like ros::spin, but returns at SIGINT (which roslaunch sends), SIGTERM and SIGHUP with the connections still open,
/// so that the caller can still publish and write. Needs ros::init_options::NoSigintHandler.
void spinUntilStopped();

template <class Node, class = void>
struct HasFinish : std::false_type {};
template <class Node>
struct HasFinish<Node, std::void_t<decltype(std::declval<Node&>().finish())>> : std::true_type {};

/// Runs a node until it is asked to end. If the node has finish(), it is called however the node ended.
/// @return exit code of the program
template <class Node>
int runNode(int argc, char** argv, const std::string& name) {
  try {
    ros::init(argc, argv, name, ros::init_options::NoSigintHandler);
  } catch (const std::exception& e) {  // an invalid name or namespace
    ROS_FATAL("%s: %s", name.c_str(), e.what());
    return 1;
  }
  ros::NodeHandle handle;  // both outlive the catch, because its message would be lost without them
  ros::NodeHandle private_handle("~");
  try {
    Node node(handle, loadNodeParameters(argc, argv, private_handle), private_handle);
    std::string failure;
    try {
      spinUntilStopped();
    } catch (const std::exception& e) {
      failure = e.what();
    }
    if constexpr (HasFinish<Node>::value) node.finish();
    if (failure.empty()) return 0;
    ROS_FATAL("%s", failure.c_str());
  } catch (const std::exception& e) {
    ROS_FATAL("%s", e.what());
  }
  return 1;
}

}  // namespace ratslam
