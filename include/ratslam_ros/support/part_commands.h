/// Commands of the map's node (map_services.h) to a node that holds a part of the map.
#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <optional>
#include <string>

#include "ratslam/common/state.h"
#include "ratslam/events.h"
#include "ratslam_ros/PartCommand.h"
#include "ratslam_ros/support/node_checkpoints.h"
#include "ratslam_ros/support/node_parameters.h"

namespace ratslam {

/// Parameters below topic_root: what the services of the map have asked for, and holds for parts that start later.
constexpr char kAskedPause[] = "ExperienceMap/asked/pause";
constexpr char kAskedLocaliseOnly[] = "ExperienceMap/asked/localise_only";

/// A message of a stream.
struct StreamPoint {
  Stamp session = 0;  ///< id of its NumberSession
  Stamp stamp = 0;

  bool operator==(const StreamPoint& other) const { return session == other.session && stamp == other.stamp; }
};

/// The functions of the part.
struct PartActions {
  std::function<void(State&)> save;
  std::function<void(const State&)> load;  ///< continues in the loaded state; the path begins unconnected
  std::function<void(bool)> setLearning;
  std::function<void()> hold;  ///< called when a hold begins; empty: nothing is to be done
  /// Continues after a hold, with all that has come meanwhile. Empty if the part is never held.
  std::function<void()> goOn;
};

class PartCommands {
 public:
  using Request = ratslam_ros::PartCommand::Request;
  using Response = ratslam_ros::PartCommand::Response;

  PartCommands(NodeCheckpoints& checkpoints, PartActions actions);

  /// Stores the part's present state as the state after a reset, and reads what the map's services have asked for: a
  /// restarted part is paused as the others are.
  void start(const ros::NodeHandle& handle, const NodeParams& params);
  /// To be called once the checkpoint is loaded: from here on the part learns, unless it must not.
  void resumed();
  /// Offers the service for commands.
  void advertise(ros::NodeHandle& handle, const std::string& service);

  const std::string& part() const { return checkpoints_.files().settings().part; }
  bool paused() const { return paused_; }

  /// Whether the part must not publish. Then its input waits, as if the node were busy.
  bool held() const { return held_until_.has_value(); }
  /// To be called regularly: ends a hold that nobody renews.
  void watchHold();
  /// To be called for each message that comes from the part before this one, and for each that goes to the next one.
  void heard(const StreamPoint& message) { heard_ = message; }
  void said(const StreamPoint& message, bool changes_map = true) {
    said_ = message;
    if (changes_map) said_change_ = message.stamp;
  }

  /// @throws std::exception with one clear line
  void run(const Request& request);
  /// What is missing up to the last message of the part before this one; empty if that has come.
  std::string missing(const StreamPoint& last) const;

 private:
  void setEmpty();
  void setLearning(bool on);
  void hold(const Request& request, Response& response);
  void goOn();
  void forgetStream();

  NodeCheckpoints& checkpoints_;
  PartActions actions_;
  std::optional<State> empty_;
  bool paused_ = false;
  bool localise_only_ = false;
  std::optional<ros::WallTime> held_until_;
  StreamPoint heard_;
  StreamPoint said_;
  Stamp said_change_ = 0;
  ros::ServiceServer server_;
};

}  // namespace ratslam
