#include "ratslam_ros/nodes/local_view_node.h"

#include <algorithm>

#include "ratslam/view/composite.h"
#include "ratslam/view/draw_local_view.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/send_queue.h"

namespace ratslam {

LocalViewNode::LocalViewNode(ros::NodeHandle handle, const ParameterMap& parameters,
                             const ros::NodeHandle& own)
    : handle_(handle),
      params_(readParams<NodeParams>(parameters)),
      stage_(readParams<LocalViewParams>(parameters), readParams<RecallGeometryParams>(parameters),
             readParams<OdometryStreamParams>(parameters)),
      checkpoints_(params_, "local_view", partParameters<LocalViewParams, RecallGeometryParams>(parameters)),
      commands_(checkpoints_, actions()),
      picture_(handle, topicName(params_.topic_root, "LocalView/View")),
      odometry_(handle, topicName(params_.topic_root, "odom"), params_.sync_timeout,
                [this](const OdometrySample& sample) {
                  std::vector<DecidedSample> verdicts = addTo(stage_, sample);
                  // If only the images' clock was set back, odometry that continues must not prevent the timeout.
                  if (drain() || !stage_.waitsForOdometryToGoBack()) odometry_timeout_.messageArrived();
                  return verdicts;
                }),
      odometry_timeout_(params_.sync_timeout),
      images_(handle, parameters, cameraHandler(),
              [this](const std_msgs::Header& header, const ImageFrame& frame) { onImage(header, frame); }),
      diagnostics_(handle, own),
      tuning_(handle, own, parameters, stage_) {
  if (!stage_.needsCamera()) resume();
  const auto topic = [this](const char* name) { return topicName(params_.topic_root, name); };
  outputs_.push_back(handle.advertise<ratslam_ros::ViewTemplate>(topic("LocalView/Template"), kSendQueue));
  if (stage_.geometrySource() != GeometrySource::kNone) {
    outputs_.push_back(
        handle.advertise<ratslam_ros::RecallGeometry>(topic("LocalView/RecallGeometry"), kSendQueue));
  }
  commands_.advertise(handle, topic("LocalView/Command"));
  gate_.emplace(handle, own, outputs_, params_.wait_for_subscribers, [this] { start(); });
  diagnostics_.addMessages("messages", guard_);
  if (stage_.needsOdometry()) diagnostics_.addMessages("odometry messages", odometry_.messages());
  diagnostics_.addImages(images_.subscriber());
  diagnostics_.add("places", [this](DiagnosticStatus& status) {
    status.summaryf(DiagnosticStatus::OK, "%zu templates", stage_.cells().size());
    status.add("templates", stage_.cells().size());
  });
  watch_timer_ =
      handle.createWallTimer(ros::WallDuration(0.2), [this](const ros::WallTimerEvent&) { watch(); });
  diagnostics_timer_ = handle.createWallTimer(ros::WallDuration(1.0),
                                              [this](const ros::WallTimerEvent&) { diagnostics_.publish(); });
}

CalibratedImages::CameraHandler LocalViewNode::cameraHandler() {
  if (!stage_.needsCamera()) return nullptr;
  return [this](const CameraModel& camera) {
    stage_.setCamera(camera);
    resume();
  };
}

PartActions LocalViewNode::actions() {
  PartActions actions;
  actions.save = [this](State& state) {
    stage_.save(state);
    images_.subscriber().save(state.child("images"));
  };
  actions.load = [this](const State& state) { stage_.load(state); };
  actions.begin = [this] {
    stage_.interrupt();
    session_ = {0, static_cast<std::uint32_t>(stage_.cells().size())};
  };
  actions.setLearning = [this](bool on) { stage_.setLearning(on); };
  actions.goOn = [this] {
    images_.subscriber().release();
    guard_.run(images_.topic(), [this] { drain(); });
  };
  actions.hold = [this] { images_.subscriber().hold(nullptr); };
  return actions;
}

void LocalViewNode::resume() {
  commands_.start(handle_, params_);
  if (const auto state = checkpoints_.resume()) {
    stage_.load(*state);
    if (checkpoints_.wentOn()) stage_.forgetWaiting();
    if (state->hasChild("images")) images_.subscriber().load(state->child("images"));
  }
  commands_.resumed();
  session_.known = static_cast<std::uint32_t>(stage_.cells().size());
}

void LocalViewNode::finish() { checkpoints_.finish(actions().save); }

void LocalViewNode::start() {
  if (stage_.needsOdometry()) odometry_.start();
  images_.start();
}

void LocalViewNode::onImage(const std_msgs::Header& header, const ImageFrame& frame) {
  last_header_ = header;
  last_image_ = frame.image;
  checkpoints_.before(frame.stamp, actions().save);
  ImageFrame seen = frame;
  if (commands_.paused()) seen.quality = ImageQuality::kBlank;
  stage_.addFrame(seen);
  drain();
}

bool LocalViewNode::drain(Passing which) {
  if (commands_.held()) return false;
  const std::vector<ViewObservation> seen = stage_.drain(which);
  publish(seen);
  return !seen.empty();
}

void LocalViewNode::watch() {
  images_.warnIfSomethingNeverCame();
  commands_.watchHold();
  if (!stage_.needsOdometry()) return;
  odometry_.watchStreams();
  if (commands_.held() || !odometry_timeout_.expired(stage_.waitingImages() > 0)) return;
  went_on_without_.report(odometry_.topic() + " is silent: images are processed without odometry");
  guard_.run(images_.topic(), [this] { drain(Passing::kAll); });
}

void LocalViewNode::publish(const std::vector<ViewObservation>& observations) {
  for (const ViewObservation& observation : observations) {
    if (session_.id == 0) session_.id = std::max<Stamp>(observation.view.stamp, 1);
    if (observation.geometry) outputs_.back().publish(geometryToMessage(*observation.geometry));
    ratslam_ros::ViewTemplate message = viewToMessage(observation.view);
    message.header.frame_id = withSession(last_header_.frame_id, session_);
    outputs_.front().publish(message);
    commands_.said({session_.id, observation.view.stamp});
  }
  if (observations.empty()) return;
  picture_.publish(last_header_, [&] {
    return drawLocalView(last_image_, observations.back().view, stage_.cells(), localViewPictureSize());
  });
}

}  // namespace ratslam
