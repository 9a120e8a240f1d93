#include "ratslam_ros/nodes/profile_odometry_node.h"
#include "ratslam_ros/support/run_node.h"

int main(int argc, char** argv) {
  return ratslam::runNode<ratslam::ProfileOdometryNode>(argc, argv, "ratslam_vo");
}
