/// Commands of the map's node (map_services.h) to a node that holds a part of the map.
#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <optional>
#include <string>

#include "ratslam/common/state.h"
#include "ratslam_ros/PartCommand.h"
#include "ratslam_ros/support/node_checkpoints.h"

namespace ratslam {

/// The functions of the part.
struct PartActions {
  std::function<void(State&)> save;
  std::function<void(const State&)> load;  ///< continues in the loaded state; the path begins unconnected
  std::function<void(bool)> setLearning;
  std::function<void(bool)> pause;  ///< empty if only the other parts pause
};

class PartCommands {
 public:
  using Request = ratslam_ros::PartCommand::Request;
  using Response = ratslam_ros::PartCommand::Response;

  PartCommands(NodeCheckpoints& checkpoints, PartActions actions);

  /// Stores the part's present state as the state after a reset.
  void setEmpty();
  /// Offers the service for commands.
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
