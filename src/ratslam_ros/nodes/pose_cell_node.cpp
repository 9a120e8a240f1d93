#include "ratslam_ros/nodes/pose_cell_node.h"

#include <algorithm>

#include "ratslam/view/composite.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/send_queue.h"

namespace ratslam {

PoseCellNode::PoseCellNode(ros::NodeHandle handle, const ParameterMap& parameters, const ros::NodeHandle& own)
    : handle_(handle),
      params_(readParams<NodeParams>(parameters)),
      stage_(readParams<PoseCellParams>(parameters), readParams<OdometryStreamParams>(parameters)),
      checkpoints_(params_, "pose_cells", partParameters<PoseCellParams>(parameters)),
      commands_(checkpoints_, actions()),
      action_publisher_(handle.advertise<ratslam_ros::TopologicalAction>(
          topicName(params_.topic_root, "PoseCell/TopologicalAction"), kSendQueue)),
      state_publisher_(handle.advertise<ratslam_ros::PoseCellState>(
          topicName(params_.topic_root, "PoseCell/State"), kSendQueue)),
      picture_(handle, topicName(params_.topic_root, "PoseCell/Activity")),
      odometry_(handle, topicName(params_.topic_root, "odom"), params_.sync_timeout,
                [this](const OdometrySample& sample) {
                  offset_.second(sample.stamp);
                  ++samples_;
                  std::vector<DecidedSample> verdicts = addTo(stage_, sample);
                  // If only the views' clock was set back, odometry that continues must not prevent the timeout.
                  if (drain() || !stage_.waitsForOdometryToGoBack()) odometry_timeout_.messageArrived();
                  return verdicts;
                }),
      views_watch_(handle.resolveName(topicName(params_.topic_root, "LocalView/Template")),
                   "ratslam_ros/ViewTemplate"),
      odometry_timeout_(params_.sync_timeout),
      diagnostics_(handle_, own),
      tuning_(handle_, own, parameters, stage_) {
  commands_.start(handle_, params_);
  if (const auto state = checkpoints_.resume()) stage_.load(*state);
  if (checkpoints_.wentOn()) stage_.forgetWaiting();
  local_view_.start(stage_.viewSession());
  commands_.heard({stage_.viewSession().id, stage_.lastView().value_or(0)});
  commands_.resumed();
  session_.known = static_cast<std::uint32_t>(stage_.cells().experiences());
  commands_.advertise(handle_, topicName(params_.topic_root, "PoseCell/Command"));
  gate_.emplace(handle, own, std::vector<ros::Publisher>{state_publisher_, action_publisher_},
                params_.wait_for_subscribers, [this] { start(); });
  watch_timer_ =
      handle.createWallTimer(ros::WallDuration(0.2), [this](const ros::WallTimerEvent&) { watch(); });
  diagnostics_.addMessages("messages", guard_);
  diagnostics_.addMessages("odometry messages", odometry_.messages());
  diagnostics_.add("streams", [this](DiagnosticStatus& status) { describe(status); });
  diagnostics_timer_ = handle.createWallTimer(ros::WallDuration(1.0),
                                              [this](const ros::WallTimerEvent&) { diagnostics_.publish(); });
}

PartActions PoseCellNode::actions() {
  PartActions actions;
  actions.save = [this](State& state) { stage_.save(state); };
  actions.load = [this](const State& state) { stage_.load(state); };
  actions.begin = [this] {
    stage_.interrupt();
    local_view_.start(stage_.viewSession());
    session_ = {0, static_cast<std::uint32_t>(stage_.cells().experiences())};
  };
  actions.setLearning = [this](bool on) { stage_.setLearning(on); };
  actions.goOn = [this] { guard_.run(views_watch_.topic(), [this] { drain(); }); };
  return actions;
}

void PoseCellNode::start() {
  odometry_.start();
  views_watch_.start();
  view_subscriber_ = guard_.subscribe<ratslam_ros::ViewTemplate>(
      handle_, views_watch_.topic(), 0,
      [this](const ratslam_ros::ViewTemplate& message) { onView(message); });
}

void PoseCellNode::onView(const ratslam_ros::ViewTemplate& message) {
  views_watch_.messageArrived();
  const ViewEvent view = viewFromMessage(message);
  offset_.first(view.stamp);
  ++views_;
  checkpoints_.before(view.stamp, [this](State& state) { stage_.save(state); });
  local_view_.heard(view.session);
  commands_.heard({view.session.id, view.stamp});
  switch (stage_.addView(view)) {
    case EventVerdict::kAccepted:
      break;
    case EventVerdict::kLate:
      late_.report(views_watch_.topic() + ": view dropped, it is older than the one before it");
      break;
    case EventVerdict::kTimeWentBack:
      time_went_back_.report(views_watch_.topic() + ": time went back, the stream starts anew");
      break;
  }
  drain();
}

bool PoseCellNode::drain(Passing which) {
  if (commands_.held()) return false;
  const std::uint64_t reseeds = stage_.cells().reseeds();
  const std::vector<PoseCellDecision> decisions = stage_.drain(which);
  died_out_.reportIncrease("all activity of the pose cells died: they start again at the last best estimate",
                           reseeds, stage_.cells().reseeds());
  publish(decisions);
  return !decisions.empty();
}

void PoseCellNode::finish() {
  checkpoints_.finish([this](State& state) { stage_.save(state); });
}

void PoseCellNode::watch() {
  odometry_.watchStreams();
  commands_.watchHold();
  views_watch_.warnIfItNeverCame();
  if (const auto complaint = offset_.complaint(views_watch_.topic(), odometry_.topic())) {
    ROS_ERROR("%s", complaint->c_str());
  }
  const bool alone = offset_.secondAlone().value_or(0.0) > params_.sync_timeout;
  if (alone && !went_alone_) {
    ROS_WARN("%s is silent while odometry goes on: pose in the map and trajectories wait for images",
             views_watch_.topic().c_str());
  }
  went_alone_ = alone;
  if (commands_.held() || !odometry_timeout_.expired(stage_.waitingViews() > 0)) return;
  const std::optional<double> lag = stage_.lag();
  const std::string offset =
      lag ? "; its newest stamp lies " + std::to_string(*lag) + " s before the waiting image's" : "";
  went_on_without_.report(odometry_.topic() + " is silent: views are processed without odometry" + offset);
  guard_.run(views_watch_.topic(), [this] { drain(Passing::kAll); });
}

void PoseCellNode::describe(DiagnosticStatus& status) {
  const double view_rate = view_rate_.perSecond(views_);
  const double odometry_rate = odometry_rate_.perSecond(samples_);
  const bool flows = view_rate > 0.0 && odometry_rate > 0.0;
  status.summaryf(flows ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                  "%.1f views, %.1f odometry messages a second", view_rate, odometry_rate);
  status.add("views [1/s]", view_rate);
  status.add("odometry [1/s]", odometry_rate);
  status.add("views that wait for odometry", stage_.waitingViews());
  status.add("odometry ahead of views [s]", offset_.seconds().value_or(0.0));
  status.add("fresh starts of the activity", stage_.cells().reseeds());
}

void PoseCellNode::publish(const std::vector<PoseCellDecision>& decisions) {
  for (const PoseCellDecision& decision : decisions) {
    if (session_.id == 0) session_.id = std::max<Stamp>(decision.view.stamp, 1);
    state_publisher_.publish(decisionToMessage(decision, session_));
    const bool changes_map = decision.action.kind != ActionKind::kNone;
    if (changes_map) action_publisher_.publish(actionToMessage(decision.action));
    commands_.said({session_.id, decision.action.stamp}, changes_map);
    trail_.add(decision.estimate);
  }
  if (decisions.empty()) return;
  std_msgs::Header header;
  header.stamp = stampToRos(decisions.back().view.stamp);
  picture_.publish(header,
                   [this] { return drawActivity(stage_.cells().activity(), trail_, activityPictureSize()); });
}

}  // namespace ratslam
