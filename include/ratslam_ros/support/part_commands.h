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

/// Parameters below topic_root that hold the last request of Pause and LocaliseOnly, for parts that start later.
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
  std::function<void(const State&)> load;  ///< takes the state; one that does not fit may leave a mixture
  /// Called when a part goes on in a state loaded by a command: the path begins unconnected.
  std::function<void()> begin;
  std::function<void(bool)> setLearning;
  std::function<void()> hold;  ///< called when a hold begins; empty: nothing is to be done
  /// Called when a hold ends: processes what has arrived meanwhile. Empty if the part is never held.
  std::function<void()> goOn;
};

class PartCommands {
 public:
  using Request = ratslam_ros::PartCommand::Request;
  using Response = ratslam_ros::PartCommand::Response;

  PartCommands(NodeCheckpoints& checkpoints, PartActions actions);

  /// Stores the part's present state as the state after a reset. Until then all commands are refused.
  void setEmpty();
  /// Does that, and reads the last requests of Pause and LocaliseOnly, so that a restarted part is paused if the others
  /// are.
  void start(const ros::NodeHandle& handle, const NodeParams& params);
  /// To be called once the checkpoint is loaded. From here on the part learns, unless LocaliseOnly forbids it.
  void resumed();
  /// Offers the service for commands.
  void advertise(ros::NodeHandle& handle, const std::string& service);

  const std::string& part() const { return checkpoints_.files().settings().part; }
  bool paused() const { return paused_; }

  /// Whether the part is held: it must not publish, and its input waits, as if the node were busy.
  bool held() const { return held_until_.has_value(); }
  /// To be called regularly. Ends a hold that has not been renewed for 10 s.
  void watchHold();
  /// To be called for each message that comes from the part before this one, and for each that goes to the next one.
  void heard(const StreamPoint& message) { heard_ = message; }
  void said(const StreamPoint& message, bool changes_map = true) {
    said_ = message;
    if (changes_map) said_change_ = message.stamp;
  }

  /// @throws std::exception with one clear line
  void run(const Request& request);
  /// A complaint if this part has not received `last`, the last message of the part before it; else empty.
  std::string missing(const StreamPoint& last) const;

 private:
  /// @return the path  @throws std::runtime_error unless it is inside the part's map_dir
  std::string inFolder(const std::string& path) const;
  /// Gives the part another state; if that does not fit, the part keeps its own one. @return its own one
  State exchange(const State& state);
  void keep();
  void check(const State& state);
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
