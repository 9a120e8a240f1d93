#include "ratslam_ros/nodes/pose_cell_node.h"
#include "ratslam_ros/support/run_node.h"

int main(int argc, char** argv) { return ratslam::runNode<ratslam::PoseCellNode>(argc, argv, "ratslam_pc"); }
