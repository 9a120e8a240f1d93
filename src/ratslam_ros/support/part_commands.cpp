#include "ratslam_ros/support/part_commands.h"

#include <ros/console.h>

#include <stdexcept>

#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/inside_folder.h"

namespace ratslam {
namespace {

/// A hold ends after this time without a command, because the node of the map may have died.
const ros::WallDuration kHold(10.0);

}  // namespace

PartCommands::PartCommands(NodeCheckpoints& checkpoints, PartActions actions)
    : checkpoints_(checkpoints), actions_(std::move(actions)) {}

void PartCommands::setEmpty() {
  State empty;
  actions_.save(empty);
  empty_ = std::move(empty);
}

void PartCommands::advertise(ros::NodeHandle& handle, const std::string& service) {
  server_ = handle.advertiseService<Request, Response>(service, [this](Request& request, Response& response) {
    try {
      if (request.command == Request::HOLD) {
        hold(request, response);
      } else {
        run(request);
      }
      if (held_until_) held_until_ = ros::WallTime::now() + kHold;
      response.success = 1;
    } catch (const std::exception& e) {
      response.message = e.what();
    }
    return true;
  });
}

void PartCommands::run(const Request& request) {
  if (!empty_) throw std::runtime_error(part() + ": it waits for the camera's calibration");
  PartCheckpoints& files = checkpoints_.files();
  switch (request.command) {
    case Request::CHECKPOINT:
      if (const auto why = files.whyNothingIsSaved()) throw std::runtime_error(part() + ": " + *why);
      files.saveNow(actions_.save);
      break;
    case Request::SAVE:
      files.saveTo(inFolder(request.path), actions_.save);
      break;
    case Request::CHECK:
      check(request.path.empty() ? *empty_ : files.loadFrom(inFolder(request.path)));
      break;
    case Request::LOAD:
      exchange(files.loadFrom(inFolder(request.path)));
      actions_.begin();
      files.continueFrom(inFolder(request.path));
      forgetStream();
      keep();
      ROS_INFO("%s: loaded from %s", part().c_str(), request.path.c_str());
      break;
    case Request::RESET:
      actions_.load(*empty_);
      actions_.begin();
      files.continueFrom("");
      forgetStream();
      keep();
      ROS_INFO("%s: everything forgotten", part().c_str());
      break;
    case Request::PAUSE:
      paused_ = request.on;
      break;
    case Request::RENEW:
      if (!held_until_) throw std::runtime_error(part() + ": it is not held");
      break;
    case Request::KEEP:
      files.saveNow(actions_.save);
      break;
    case Request::LEARN:
      setLearning(request.on);
      break;
    default:
      throw std::invalid_argument("command " + std::to_string(request.command) + " is unknown");
  }
}

std::string PartCommands::inFolder(const std::string& path) const {
  const PartCheckpoints& files = checkpoints_.files();
  try {
    if (!files.enabled()) throw std::runtime_error(*files.whyNothingIsSaved());
    return pathInside(path, {files.settings().folder}, "");
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(part() + ": " + e.what());
  }
}

State PartCommands::exchange(const State& state) {
  State own;
  actions_.save(own);
  try {
    actions_.load(state);
  } catch (...) {
    actions_.load(own);
    throw;
  }
  return own;
}

/// Takes a checkpoint of the exchanged state. Else a node that is killed would return with the map before, while the
/// others go on in this one.
void PartCommands::keep() {
  PartCheckpoints& files = checkpoints_.files();
  if (!files.enabled()) return;
  try {
    if (const auto why = files.whyNothingIsSaved()) throw std::runtime_error(*why);
    files.saveNow(actions_.save);
  } catch (const std::exception& e) {
    ROS_WARN("%s: not in the checkpoints, a restart returns to the map before: %s", part().c_str(), e.what());
  }
}

/// Tests whether a state fits and can be kept. Nothing changes.
void PartCommands::check(const State& state) {
  const State own = exchange(state);
  try {
    checkpoints_.files().requireRoom(actions_.save);
  } catch (...) {
    actions_.load(own);
    throw;
  }
  actions_.load(own);
}

void PartCommands::setLearning(bool on) {
  try {
    checkpoints_.files().setReadOnly(!on);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(part() + ": " + e.what());
  }
  actions_.setLearning(on);
}

void PartCommands::start(const ros::NodeHandle& handle, const NodeParams& params) {
  setEmpty();
  const auto asked = [&](const char* what) { return handle.resolveName(topicName(params.topic_root, what)); };
  if (handle.getParam(asked(kAskedPause), paused_) && paused_) {
    ROS_WARN("%s: paused, as ExperienceMap/Pause asked before it started (parameter %s)", part().c_str(),
             asked(kAskedPause).c_str());
  }
  localise_only_ = params.localise_only;
  if (handle.getParam(asked(kAskedLocaliseOnly), localise_only_) && localise_only_ != params.localise_only) {
    ROS_WARN("%s: localise_only is %s, as ExperienceMap/LocaliseOnly asked before it started (parameter %s)",
             part().c_str(), localise_only_ ? "true" : "false", asked(kAskedLocaliseOnly).c_str());
  }
}

void PartCommands::resumed() { setLearning(!localise_only_); }

void PartCommands::hold(const Request& request, Response& response) {
  if (!empty_) throw std::runtime_error(part() + ": it waits for the camera's calibration");
  if (request.on == 0) {
    if (!held_until_) throw std::runtime_error(part() + ": it went on before it was told to");
    goOn();
    return;
  }
  if (!actions_.goOn) throw std::invalid_argument(part() + ": it cannot be held");
  response.message = missing({stampFromRos(request.session), stampFromRos(request.stamp)});
  response.later = response.message.empty() ? 0 : 1;
  if (response.later == 0) {
    if (!held_until_ && actions_.hold) actions_.hold();
    held_until_ = ros::WallTime::now() + kHold;
  }
  const StreamPoint& last = response.later == 0 ? said_ : heard_;
  response.session = stampToRos(last.session);
  response.stamp = stampToRos(last.stamp);
  response.action_stamp = stampToRos(said_change_);
}

std::string PartCommands::missing(const StreamPoint& last) const {
  if (last.stamp == 0 || heard_ == last) return "";
  const auto seconds = [](Stamp stamp) { return std::to_string(secondsBetween(0, stamp)) + " s"; };
  return part() + ": it has not received the message at " + seconds(last.stamp) +
         " of the node before it; its last one is that at " + seconds(heard_.stamp);
}

void PartCommands::watchHold() {
  if (!held_until_ || ros::WallTime::now() < *held_until_) return;
  ROS_WARN("%s: the map's node did not renew its hold within 10 s: processing continues", part().c_str());
  goOn();
}

void PartCommands::goOn() {
  held_until_.reset();
  actions_.goOn();
}

/// Forgets the messages so far, which belong to another map.
void PartCommands::forgetStream() {
  heard_ = {};
  said_ = {};
  said_change_ = 0;
}

}  // namespace ratslam
