/// Calls of the map's services to the other nodes that hold a part of the map.
///
/// A stopped node never answers, and roscpp waits for ever. So each call has a time limit, and waits in a thread of its
/// own. While the parts are held, local view and pose cells publish nothing, and each part has received everything that
/// the part before it published.
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
  /// What the map has not received or processed yet, up to the last message of the pose cells; empty if there is
  /// nothing.
  using Behind = std::function<std::string(const StreamPoint& last, Stamp last_change)>;

  /// @param services  names, from the first part of the chain to the last   @param patience  see standStill [s]
  PartCalls(const ros::NodeHandle& handle, std::vector<std::string> services, double patience);

  /// Lets all calls and waits end, so that a thread within them can be joined.
  void end() { ending_ = true; }

  /// @throws std::runtime_error naming a service that no node offers
  void requireAll() const;
  /// Sends a command to each service. @return the names of the services   @throws std::runtime_error with one clear
  /// line
  std::string toAll(const Request& request);
  void send(const std::string& service, const Request& request);
  const std::vector<std::string>& services() const { return services_; }

  /// Waits until `done` returns true, and renews the holds while it waits. @return whether it did within `limit_s` [s]
  /// @throws std::runtime_error if the node ends
  bool wait(const std::function<bool()>& done, double limit_s);

  /// Holds all parts at one message. @return empty if that succeeds; else the reason: a part has made no progress for
  /// `patience`, because it was restarted and has lost messages   @throws std::runtime_error with one clear line
  std::string standStill(const Behind& behind);
  /// Ends the holds. @return a complaint about a part whose hold had ended before, in one line; empty if there is none
  std::string goOn();

 private:
  Response call(const std::string& service, const Request& request, double limit_s);
  /// Holds a part once it has received `last`. @param why  gets the reason if the part is held without having received
  /// it
  Response hold(const std::string& service, const StreamPoint& last, std::string& why);
  void renewHolds();
  /// Sleeps for 10 ms and renews the holds.
  void rest();

  ros::NodeHandle handle_;
  std::vector<std::string> services_;
  double patience_;
  std::vector<std::string> held_;
  ros::WallTime renewed_;
  bool renewing_ = false;
  std::atomic<bool> ending_{false};
};

/// Holds the parts; the destructor releases them.
class Standstill {
 public:
  Standstill(PartCalls& calls, const PartCalls::Behind& behind);
  ~Standstill();
  Standstill(const Standstill&) = delete;
  Standstill& operator=(const Standstill&) = delete;

  /// Releases the parts. @return empty if they were held at one message all the time, else why not
  std::string end();

 private:
  PartCalls& calls_;
  std::string why_;
};

}  // namespace ratslam
