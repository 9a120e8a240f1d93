#include "ratslam_ros/local_view_node.h"

#include "ratslam/view/composite.h"
#include "ratslam/view/draw_local_view.h"
#include "ratslam_ros/conversions.h"

namespace ratslam {

LocalViewNode::LocalViewNode(ros::NodeHandle handle, const ParameterMap& parameters)
    : params_(readParams<NodeParams>(parameters)),
      cells_(readParams<LocalViewParams>(parameters)),
      template_publisher_(handle.advertise<ratslam_ros::ViewTemplate>(
          topicName(params_.topic_root, "LocalView/Template"), 0)),
      picture_(handle, topicName(params_.topic_root, "LocalView/View")),
      images_(handle, params_, topicName(params_.topic_root, "camera/image"),
              [this](const std_msgs::Header& header, const cv::Mat& image) { onImage(header, image); }) {
  gate_.emplace(handle, std::vector<ros::Publisher>{template_publisher_}, params_.wait_for_subscribers,
                [this] { images_.start(); });
  watch_timer_ = handle.createWallTimer(
      ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { images_.watch().warnIfItNeverCame(); });
}

void LocalViewNode::onImage(const std_msgs::Header& header, const cv::Mat& image) {
  const ViewEvent view = cells_.observe(stampFromRos(header.stamp), image);
  ratslam_ros::ViewTemplate message = viewToMessage(view);
  message.header.frame_id = header.frame_id;
  template_publisher_.publish(message);
  picture_.publish(header, [&] {
    return drawLocalView(image, view, cells_.viewImage(), cells_.templateImage(view.id),
                         localViewPictureSize());
  });
}

}  // namespace ratslam
