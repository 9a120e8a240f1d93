#include "ratslam_ros/nodes/orb_odometry_node.h"

#include "ratslam_ros/support/conversions.h"

namespace ratslam {
namespace {

constexpr std::size_t kManyImages = 100;  // by then a camera that moves is tracked

}  // namespace

OrbOdometryNode::OrbOdometryNode(ros::NodeHandle handle, const ParameterMap& parameters,
                                 const ros::NodeHandle& own)
    : params_(odometryNodeParams(parameters)),
      odometry_params_(readParams<OrbOdometryParams>(parameters)),
      image_params_(readParams<ImageStageParams>(parameters)),
      part_parameters_(partParameters<OrbOdometryParams>(parameters)),
      publisher_(handle, params_),
      display_(params_, own),
      images_(
          handle, parameters, [this](const CameraModel& camera) { onCamera(camera); },
          [this](const std_msgs::Header& header, const ImageFrame& frame) { onImage(header, frame); }),
      diagnostics_(handle, own) {
  mount_.emplace(handle, params_.base_frame, odometry_params_, [this, handle, own] {
    gate_.emplace(handle, own, publisher_.publishers(), params_.wait_for_subscribers,
                  [this] { images_.start(); });
  });
  diagnostics_.addImages(images_.subscriber());
  diagnostics_.add("visual odometry", [this](DiagnosticStatus& status) {
    display_.describe(status, source_ ? &source_->odometry() : nullptr);
  });
  watch_timer_ = handle.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) {
    images_.warnIfSomethingNeverCame();
    diagnostics_.publish();
  });
}

void OrbOdometryNode::onCamera(const CameraModel& camera) {
  source_.emplace(camera, odometry_params_);
  checkpoints_.emplace(params_, image_params_, part_parameters_, *source_, publisher_, images_.subscriber());
  checkpoints_->resume();
}

void OrbOdometryNode::sayWhatIsNotTracked() const {
  const auto failure = source_ ? source_->failure() : std::nullopt;
  if (failure) ROS_WARN("%s; a map begins once the camera moves and sees texture", failure->c_str());
}

void OrbOdometryNode::finish() {
  sayWhatIsNotTracked();
  if (checkpoints_) checkpoints_->finish();
}

void OrbOdometryNode::onImage(const std_msgs::Header& header, const ImageFrame& frame) {
  const ros::WallTime begin = ros::WallTime::now();
  const OdometrySample sample = source_->track(checkpoints_->before(frame));
  const OrbResult& result = *source_->result();
  if (++seen_ == kManyImages) sayWhatIsNotTracked();
  if (result.restarted) restarted_.report("tracking was lost: a fresh map carries pose and scale on");
  publisher_.publish(sample, result.twist);
  display_.show(header, frame.image, source_->camera(), source_->odometry(), result,
                (ros::WallTime::now() - begin).toSec());
}

}  // namespace ratslam
