#include "ratslam_ros/nodes/profile_odometry_node.h"

#include "ratslam_ros/support/conversions.h"

namespace ratslam {

ProfileOdometryNode::ProfileOdometryNode(ros::NodeHandle handle, const ParameterMap& parameters,
                                         const ros::NodeHandle& own)
    : params_(odometryNodeParams(parameters)),
      odometry_params_(readParams<ProfileOdometryParams>(parameters)),
      source_(odometry_params_),
      publisher_(handle, params_),
      images_(handle, params_, readParams<ImageStageParams>(parameters),
              topicName(params_.topic_root, "camera/image"),
              [this](const std_msgs::Header& header, const ImageFrame& frame) { onImage(header, frame); }),
      checkpoints_(params_, readParams<ImageStageParams>(parameters),
                   partParameters<ProfileOdometryParams>(parameters), source_, publisher_, images_),
      diagnostics_(handle, own) {
  checkpoints_.resume();
  gate_.emplace(handle, own, publisher_.publishers(), params_.wait_for_subscribers,
                [this] { images_.start(); });
  diagnostics_.addImages(images_);
  watch_timer_ = handle.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) {
    images_.watchStream();
    diagnostics_.publish();
  });
}

void ProfileOdometryNode::onImage(const std_msgs::Header&, const ImageFrame& frame) {
  publisher_.publish(source_.track(checkpoints_.before(frame)), Twist::Zero());
}

}  // namespace ratslam
