#include "ratslam_ros/nodes/local_view_node.h"
#include "ratslam_ros/support/run_node.h"

int main(int argc, char** argv) { return ratslam::runNode<ratslam::LocalViewNode>(argc, argv, "ratslam_lv"); }
