#include "ratslam_ros/nodes/local_view_node.h"

#include "ratslam/view/composite.h"
#include "ratslam/view/draw_local_view.h"
#include "ratslam_ros/support/conversions.h"

namespace ratslam {

LocalViewNode::LocalViewNode(ros::NodeHandle handle, const ParameterMap& parameters)
    : params_(readParams<NodeParams>(parameters)),
      stage_(readParams<LocalViewParams>(parameters), readParams<RecallGeometryParams>(parameters)),
      picture_(handle, topicName(params_.topic_root, "LocalView/View")),
      images_(handle, parameters, cameraHandler(),
              [this](const std_msgs::Header& header, const ImageFrame& frame) { onImage(header, frame); }) {
  const auto topic = [this](const char* name) { return topicName(params_.topic_root, name); };
  outputs_.push_back(handle.advertise<ratslam_ros::ViewTemplate>(topic("LocalView/Template"), 0));
  if (stage_.needsCamera()) {
    outputs_.push_back(handle.advertise<ratslam_ros::RecallGeometry>(topic("LocalView/RecallGeometry"), 0));
  }
  gate_.emplace(handle, outputs_, params_.wait_for_subscribers, [this] { images_.start(); });
  watch_timer_ = handle.createWallTimer(
      ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { images_.warnIfSomethingNeverCame(); });
}

CalibratedImages::CameraHandler LocalViewNode::cameraHandler() {
  if (!stage_.needsCamera()) return nullptr;
  return [this](const CameraModel& camera) { stage_.setCamera(camera); };
}

void LocalViewNode::onImage(const std_msgs::Header& header, const ImageFrame& frame) {
  const ViewObservation observation = stage_.observe(frame);
  if (observation.geometry) outputs_.back().publish(geometryToMessage(*observation.geometry));
  ratslam_ros::ViewTemplate message = viewToMessage(observation.view);
  message.header.frame_id = header.frame_id;
  outputs_.front().publish(message);
  picture_.publish(header, [&] {
    return drawLocalView(frame.image, observation.view, stage_.cells(), localViewPictureSize());
  });
}

}  // namespace ratslam
