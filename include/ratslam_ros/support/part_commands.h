/// What a node that keeps a share of the map does for the services of the map's node (map_services.h).
#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <optional>
#include <string>

#include "ratslam/common/state.h"
#include "ratslam_ros/PartCommand.h"
#include "ratslam_ros/support/node_checkpoints.h"

namespace ratslam {

/// The part itself.
struct PartActions {
  std::function<void(State&)> save;
  std::function<void(const State&)> load;  ///< a new stretch begins in what is loaded
  std::function<void(bool)> setLearning;
  std::function<void(bool)> pause;  ///< none where only others need to
};

class PartCommands {
 public:
  using Request = ratslam_ros::PartCommand::Request;
  using Response = ratslam_ros::PartCommand::Response;

  PartCommands(NodeCheckpoints& checkpoints, PartActions actions);

  /// The part as it is now is what a reset goes back to.
  void setEmpty();
  /// From here on others may command.
  void advertise(ros::NodeHandle& handle, const std::string& service);

  const std::string& part() const { return checkpoints_.files().settings().part; }
  bool paused() const { return paused_; }

  /// @throws std::exception with one clear line
  void run(const Request& request);

 private:
  NodeCheckpoints& checkpoints_;
  PartActions actions_;
  std::optional<State> empty_;
  bool paused_ = false;
  ros::ServiceServer server_;
};

}  // namespace ratslam
