/// The nodes with images, as nodelets: in one process with a camera's driver images are not copied. They use the classes
/// of the nodes, so the results are the same.
#include <nodelet/nodelet.h>

#include <future>
#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "ratslam_ros/nodes/local_view_node.h"
#include "ratslam_ros/nodes/orb_odometry_node.h"
#include "ratslam_ros/nodes/profile_odometry_node.h"
#include "ratslam_ros/support/node_failure.h"
#include "ratslam_ros/support/run_node.h"

namespace ratslam {

template <class Node>
class NodeAsNodelet : public nodelet::Nodelet {
 public:
  ~NodeAsNodelet() override {
    try {
      if constexpr (HasFinish<Node>::value) {
        if (node_) node_->finish();
      }
    } catch (const std::exception& e) {
      ROS_ERROR("%s: %s", getName().c_str(), e.what());
    }
  }

 private:
  /// Makes the node in the thread of its callbacks, so that no callback runs before it is complete.
  void onInit() override {
    setProcessIsShared();
    std::promise<void> made;
    getSTCallbackQueue().addCallback(boost::make_shared<PostedCall>([this, &made] {
      try {
        make();
        made.set_value();
      } catch (...) {
        made.set_exception(std::current_exception());
      }
    }));
    try {
      made.get_future().get();
    } catch (const std::exception& e) {
      ROS_FATAL("%s: %s", getName().c_str(), e.what());
      throw;
    }
  }

  void make() {
    std::vector<const char*> arguments{getName().c_str()};
    for (const std::string& argument : getMyArgv()) arguments.push_back(argument.c_str());
    const ros::NodeHandle& own = getPrivateNodeHandle();
    node_ = std::make_unique<Node>(
        getNodeHandle(), loadNodeParameters(static_cast<int>(arguments.size()), arguments.data(), own), own);
  }

  std::unique_ptr<Node> node_;
};

using LocalViewNodelet = NodeAsNodelet<LocalViewNode>;
using OrbOdometryNodelet = NodeAsNodelet<OrbOdometryNode>;
using ProfileOdometryNodelet = NodeAsNodelet<ProfileOdometryNode>;

}  // namespace ratslam

PLUGINLIB_EXPORT_CLASS(ratslam::LocalViewNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(ratslam::OrbOdometryNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(ratslam::ProfileOdometryNodelet, nodelet::Nodelet)
