#include "ratslam_ros/support/part_commands.h"

#include <ros/console.h>

#include <stdexcept>

namespace ratslam {

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
      run(request);
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
      files.saveTo(request.path, actions_.save);
      break;
    case Request::CHECK:
      files.loadFrom(request.path);
      break;
    case Request::LOAD:
      actions_.load(files.loadFrom(request.path));
      ROS_INFO("%s: loaded from %s", part().c_str(), request.path.c_str());
      break;
    case Request::RESET:
      actions_.load(*empty_);
      ROS_INFO("%s: everything forgotten", part().c_str());
      break;
    case Request::PAUSE:
      paused_ = request.on;
      if (actions_.pause) actions_.pause(paused_);
      break;
    case Request::LEARN:
      files.setReadOnly(!request.on);
      actions_.setLearning(request.on);
      break;
    default:
      throw std::invalid_argument("command " + std::to_string(request.command) + " is unknown");
  }
}

}  // namespace ratslam
