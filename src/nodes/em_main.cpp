#include <ros/ros.h>

#include "ratslam_ros/nodes/map_node.h"
#include "ratslam_ros/support/spin.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "ratslam_em", ros::init_options::NoSigintHandler);
  ros::NodeHandle handle;  // both outlive the catch, else its message is lost
  ros::NodeHandle private_handle("~");
  try {
    ratslam::MapNode node(handle, ratslam::loadNodeParameters(argc, argv, private_handle));
    ratslam::spinUntilInterrupted();
    node.finish();
  } catch (const std::exception& e) {
    ROS_FATAL("%s", e.what());
    return 1;
  }
  return 0;
}
