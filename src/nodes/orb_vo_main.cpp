#include "ratslam_ros/nodes/orb_odometry_node.h"
#include "ratslam_ros/support/run_node.h"

int main(int argc, char** argv) {
  return ratslam::runNode<ratslam::OrbOdometryNode>(argc, argv, "ratslam_orb_vo");
}
