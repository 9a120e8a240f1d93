#include "ratslam_ros/nodes/local_view_node.h"

#include "ratslam/view/composite.h"
#include "ratslam/view/draw_local_view.h"
#include "ratslam_ros/support/conversions.h"

namespace ratslam {

LocalViewNode::LocalViewNode(ros::NodeHandle handle, const ParameterMap& parameters)
    : params_(readParams<NodeParams>(parameters)),
      recall_params_(readParams<RecallGeometryParams>(parameters)),
      cells_(readParams<LocalViewParams>(parameters)),
      picture_(handle, topicName(params_.topic_root, "LocalView/View")),
      images_(handle, params_, readParams<CameraParams>(parameters), cameraHandler(),
              [this](const std_msgs::Header& header, const cv::Mat& image) { onImage(header, image); }) {
  const auto topic = [this](const char* name) { return topicName(params_.topic_root, name); };
  outputs_.push_back(handle.advertise<ratslam_ros::ViewTemplate>(topic("LocalView/Template"), 0));
  if (recall_params_.verifies()) {
    outputs_.push_back(handle.advertise<ratslam_ros::RecallGeometry>(topic("LocalView/RecallGeometry"), 0));
  }
  gate_.emplace(handle, outputs_, params_.wait_for_subscribers, [this] { images_.start(); });
  watch_timer_ = handle.createWallTimer(
      ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { images_.warnIfSomethingNeverCame(); });
}

CalibratedImages::CameraHandler LocalViewNode::cameraHandler() {
  if (!recall_params_.verifies()) return nullptr;
  return [this](const CameraModel& camera) {
    recall_check_ = std::make_unique<RecallCheck>(recall_params_, camera);
  };
}

ViewEvent LocalViewNode::observe(Stamp stamp, const cv::Mat& image) {
  if (!recall_check_) return cells_.observe(stamp, image);
  RecallGeometry geometry;
  const ViewEvent view = recall_check_->observe(cells_, stamp, image, geometry);
  outputs_.back().publish(geometryToMessage(geometry));
  return view;
}

void LocalViewNode::onImage(const std_msgs::Header& header, const cv::Mat& image) {
  const ViewEvent view = observe(stampFromRos(header.stamp), image);
  ratslam_ros::ViewTemplate message = viewToMessage(view);
  message.header.frame_id = header.frame_id;
  outputs_.front().publish(message);
  picture_.publish(header, [&] {
    return drawLocalView(image, view, cells_.viewImage(), cells_.templateImage(view.id),
                         localViewPictureSize());
  });
}

}  // namespace ratslam
