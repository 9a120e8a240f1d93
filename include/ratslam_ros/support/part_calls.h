/// Calls of the map's services to the other nodes that hold a part of the map.
///
/// A stopped node never answers, and roscpp waits for ever. So each call has a limit, and waits in a thread of its own.
/// While the parts stand still, one message is the last for all of them: local view and pose cells publish nothing, and
/// each part has received what the part before it has published.
#pragma once

#include <ros/node_handle.h>

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "ratslam_ros/support/part_commands.h"

namespace ratslam {

class PartCalls {
 public:
  using Request = PartCommands::Request;
  using Response = PartCommands::Response;
  /// What the map has not received or processed yet, up to the last message of the pose cells; empty if nothing.
  using Behind = std::function<std::string(const StreamPoint& last, Stamp last_change)>;

  /// @param services  names, from the first part of the chain to the last   @param patience  see standStill [s]
  PartCalls(const ros::NodeHandle& handle, std::vector<std::string> services, double patience);

  /// Lets all calls and waits end, so that a thread within them can be joined.
  void end() { ending_ = true; }

  /// @throws std::runtime_error naming those that nobody offers
  void requireAll() const;
  /// Sends a command to each. @return their names   @throws std::runtime_error with one clear line
  std::string toAll(const Request& request);
  void send(const std::string& service, const Request& request);
  const std::vector<std::string>& services() const { return services_; }

  /// Waits until `done`, and meanwhile lets nobody go on. @return whether it was done within `limit_s`
  /// @throws std::runtime_error if the node ends
  bool wait(const std::function<bool()>& done, double limit_s);

  /// Lets the parts stand still. @return why they do not stand at one message: a part makes no progress for `patience`,
  /// because it was restarted and has lost messages; empty if they do   @throws std::runtime_error with one clear line
  std::string standStill(const Behind& behind);
  /// @return who went on too early, in one line; empty if all stood still
  std::string goOn();

 private:
  Response call(const std::string& service, const Request& request, double limit_s);
  /// Holds a part once it has received `last`. @param why  gets the reason if it is held without
  Response hold(const std::string& service, const StreamPoint& last, std::string& why);
  void renewHolds();
  /// Waits a moment.
  void rest();

  ros::NodeHandle handle_;
  std::vector<std::string> services_;
  double patience_;
  std::vector<std::string> held_;
  ros::WallTime renewed_;
  bool renewing_ = false;
  std::atomic<bool> ending_{false};
};

/// Holds nobody longer than it lives.
class Standstill {
 public:
  Standstill(PartCalls& calls, const PartCalls::Behind& behind);
  ~Standstill();
  Standstill(const Standstill&) = delete;
  Standstill& operator=(const Standstill&) = delete;

  /// Lets the parts go on. @return why what happened meanwhile did not happen at one message; empty if it did
  std::string end();

 private:
  PartCalls& calls_;
  std::string why_;
};

}  // namespace ratslam
