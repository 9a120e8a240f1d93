/// Lets a node subscribe only once its outputs have subscribers, so that a playback loses no message at its start: the
/// last node of the chain subscribes first, and the player waits for all nodes. Once it has subscribed, the node
/// advertises ~started, on which nothing is published. The player waits for it, because nodelets of one process share
/// connections, which do not show which of them has subscribed.
#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <functional>
#include <vector>

namespace ratslam {

class StartGate {
 public:
  /// Calls `start` at once if `count` is 0, else as soon as each of `outputs` has `count` subscribers. After 15 s it
  /// warns and calls `start` anyway.
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
