#include "ratslam_ros/nodes/map_node.h"

#include "ratslam/system/local_view_stage.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/trajectory_files.h"

namespace ratslam {

MapNode::MapNode(const ros::NodeHandle& handle, const ParameterMap& parameters, const ros::NodeHandle& own)
    : handle_(handle),
      params_(readParams<NodeParams>(parameters)),
      geometry_(geometrySource(readParams<ViewRecallParams>(parameters),
                               readParams<RecallGeometryParams>(parameters))),
      stage_(readParams<ExperienceMapParams>(parameters), geometry_,
             readParams<OdometryStreamParams>(parameters)),
      checkpoints_(params_, "experience_map", partParameters<ExperienceMapParams>(parameters)),
      commands_(checkpoints_, actions()),
      publisher_(handle_, params_, readParams<ExperienceMapParams>(parameters).exp_scale),
      odometry_(handle, topicName(params_.topic_root, "odom"), params_.sync_timeout,
                [this](const OdometrySample& sample) {
                  std::vector<DecidedSample> verdicts = addTo(stage_, sample);
                  for (const DecidedSample& decided : verdicts) odometry_frame_.follow(decided);
                  drain(Passing::kReached);
                  if (stage_.map().currentExperience()) {
                    publisher_.followOdometry(stage_.latestPose(), odometry_frame_);
                  }
                  return verdicts;
                }),
      decisions_watch_(handle.resolveName(topicName(params_.topic_root, "PoseCell/TopologicalAction")),
                       "ratslam_ros/TopologicalAction"),
      source_(params_.decision_source,
              [topic = handle.resolveName(topicName(params_.topic_root, "PoseCell/State"))] {
                return isPublished(topic).value_or(false);
              }),
      silence_(params_.sync_timeout),
      services_(
          handle_, params_, commands_, [this] { return isEmpty(); },
          [this](const std::string& file) { return write(file, *stage_.map().settled()); },
          [this](const StreamPoint& last, Stamp change, bool all) { return behind(last, change, all); }),
      rivals_(handle_, odometry_.topic()),
      diagnostics_(handle_, own),
      changes_(handle_, topicName(params_.topic_root, "ParameterChange")),
      tuning_(handle_, own, parameters, stage_) {
  requireTrajectoriesWritable(params_.trajectory_file, params_.trajectory_format);
  commands_.start(handle_, params_);
  if (const auto state = checkpoints_.resume()) {
    stage_.load(*state);
    changes_.load(*state);
    publisher_.replaceMap(stage_.map());
  }
  pose_cells_.start(stage_.session());
  commands_.heard({stage_.session().id, stage_.lastDecision().value_or(0)});
  commands_.resumed();
  subscribe();
  watch_timer_ =
      handle_.createWallTimer(ros::WallDuration(0.2), [this](const ros::WallTimerEvent&) { watch(); });
  diagnostics_.addMessages("messages", guard_);
  diagnostics_.addMessages("odometry messages", odometry_.messages());
  diagnostics_.add("map", [this](DiagnosticStatus& status) { reports_.describe(status, stage_); });
  rivals_.watchFrame(params_.base_frame);
  diagnostics_timer_ = handle_.createWallTimer(
      ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { diagnostics_.publish(); });
}

void MapNode::subscribe() {
  const auto topic = [this](const char* name) { return topicName(params_.topic_root, name); };
  odometry_.start();
  decisions_watch_.start();
  subscribers_.push_back(guard_.subscribe<ratslam_ros::PoseCellState>(
      handle_, topic("PoseCell/State"), 0, [this](const ratslam_ros::PoseCellState& message) {
        if (source_.takesState()) onDecision(message);
      }));
  subscribers_.push_back(guard_.subscribe<ratslam_ros::TopologicalAction>(
      handle_, decisions_watch_.topic(), 0, [this](const ratslam_ros::TopologicalAction& message) {
        if (source_.takesAction()) onDecision(message);
      }));
  if (geometry_ != GeometrySource::kNone) {
    subscribers_.push_back(guard_.subscribe<ratslam_ros::RecallGeometry>(
        handle_, topic("LocalView/RecallGeometry"), 0, [this](const ratslam_ros::RecallGeometry& message) {
          stage_.addGeometry(geometryFromMessage(message));
          drain(Passing::kReached);
        }));
  }
  subscribers_.push_back(guard_.subscribe<geometry_msgs::PoseStamped>(
      handle_, topic("ExperienceMap/SetGoalPose"), 1, [this](const geometry_msgs::PoseStamped& message) {
        goals_.take(message, params_.map_frame, stage_.map(), publisher_);
      }));
}

template <class Message>
void MapNode::onDecision(const Message& message) {
  decisions_watch_.messageArrived();
  const TopologicalAction action = actionFromMessage(message);
  checkpoints_.before(action.stamp, actions().save);
  pose_cells_.heard(action.session);
  commands_.heard({action.session.id, action.stamp});
  if (!stage_.addDecision(action)) reports_.timeWentBack();
  drain(Passing::kReached);
}

void MapNode::drain(Passing which) {
  publisher_.setOdometryFrame(params_.odomFrame(odometry_.frame()));
  const std::vector<Stamp> processed = reports_.drain(stage_, which);
  for (const DecidedSample& decided : stage_.takeDecided()) odometry_frame_.follow(decided);
  if (which == Passing::kReached && !processed.empty()) silence_.messageArrived();
  publisher_.publish(stage_.map(), processed, odometry_frame_);
  goals_.report(stage_.map(), publisher_, !processed.empty());
}

void MapNode::watch() {
  rivals_.watchFrame(params_.odomFrame(odometry_.frame()));
  odometry_.watchStreams();
  decisions_watch_.warnIfItNeverCame();
  publisher_.publishMapIfDue(stage_.map());
  if (!silence_.expired(stage_.waitingDecisions() > 0)) return;
  went_on_without_.report(odometry_.topic() +
                          (geometry_ != GeometrySource::kNone ? " or LocalView/RecallGeometry" : "") +
                          " is silent: decisions are processed without it");
  guard_.run(decisions_watch_.topic(), [this] { drain(Passing::kAll); });
}

std::string MapNode::behind(const StreamPoint& last, Stamp last_change, bool all) const {
  // A TopologicalAction has no field for the session.
  std::string missing = commands_.missing(source_.followsActions() ? StreamPoint{0, last_change} : last);
  const std::size_t waiting = all ? stage_.waitingDecisions() : 0;
  if (!missing.empty() || waiting == 0) return missing;
  return "in the experience map " + std::to_string(waiting) + " decisions wait for odometry";
}

PartActions MapNode::actions() {
  PartActions actions;
  actions.save = [this](State& state) {
    stage_.save(state);
    changes_.save(state);
  };
  actions.load = [this](const State& state) {
    stage_.load(state);
    changes_.load(state);
  };
  actions.begin = [this] {
    stage_.interrupt();
    pose_cells_.start(stage_.session());
    goals_.forget();
    publisher_.replaceMap(stage_.map());
  };
  actions.setLearning = [this](bool on) { stage_.setLearning(on); };
  return actions;
}

std::string MapNode::write(const std::string& file, const ExperienceMap& map) {
  const TrajectoryFiles files = writeTrajectories(map, file, params_.trajectory_format);
  changes_.write(file);
  return files.online + ", " + files.final;
}

void MapNode::finish() {
  checkpoints_.finish(actions().save);
  stage_.map().settle();
  publisher_.publishMap(stage_.map());
  if (params_.trajectory_file.empty()) return;
  reportTrajectories(write(params_.trajectory_file, stage_.map()), isEmpty());
}

}  // namespace ratslam
