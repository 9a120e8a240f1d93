/// Lets a node listen only once somebody listens to it, so that a playback loses no message at its start: the
/// last node of the chain starts first, and the player waits for all of them. Once a node listens it advertises
/// ~started: nodelets of one process share their connections, which therefore cannot tell that.
#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <functional>
#include <vector>

namespace ratslam {

class StartGate {
 public:
  /// Calls `start` at once where `count` is 0, else as soon as each of `outputs` has `count` subscribers;
  /// gives up waiting with a warning after 15 s.
  /// @param own  handle of the node's private names
  StartGate(const ros::NodeHandle& handle, const ros::NodeHandle& own, std::vector<ros::Publisher> outputs,
            int count, std::function<void()> start);

 private:
  void check();
  void open();

  ros::NodeHandle own_;
  std::vector<ros::Publisher> outputs_;
  std::uint32_t count_;
  std::function<void()> start_;
  ros::WallTime since_;
  ros::WallTimer timer_;
  ros::Publisher started_;
};

}  // namespace ratslam
