#include <ros/ros.h>

#include "ratslam_ros/nodes/pose_cell_node.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "ratslam_pc");
  ros::NodeHandle handle;  // both outlive the catch, else its message is lost
  ros::NodeHandle private_handle("~");
  try {
    ratslam::PoseCellNode node(handle, ratslam::loadNodeParameters(argc, argv, private_handle));
    ros::spin();
  } catch (const std::exception& e) {
    ROS_FATAL("%s", e.what());
    return 1;
  }
  return 0;
}
