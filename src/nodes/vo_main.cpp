#include <ros/ros.h>

#include "ratslam_ros/nodes/profile_odometry_node.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "ratslam_vo");
  ros::NodeHandle handle;  // both outlive the catch, else its message is lost
  ros::NodeHandle private_handle("~");
  try {
    ratslam::ProfileOdometryNode node(handle, ratslam::loadNodeParameters(argc, argv, private_handle));
    ros::spin();
  } catch (const std::exception& e) {
    ROS_FATAL("%s", e.what());
    return 1;
  }
  return 0;
}
