#include "ratslam_ros/nodes/map_node.h"
#include "ratslam_ros/support/run_node.h"

int main(int argc, char** argv) { return ratslam::runNode<ratslam::MapNode>(argc, argv, "ratslam_em"); }
