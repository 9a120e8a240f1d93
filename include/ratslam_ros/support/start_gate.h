/// Lets a node listen only once somebody listens to it, so that a playback loses no message at its start: the
/// last node of the chain starts first, and the player waits for all of them.
#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <functional>
#include <vector>

namespace ratslam {

class StartGate {
 public:
  /// Calls `open` at once where `count` is 0, else as soon as each of `outputs` has `count` subscribers;
  /// gives up waiting with a warning after 15 s.
  StartGate(const ros::NodeHandle& handle, std::vector<ros::Publisher> outputs, int count,
            std::function<void()> open);

 private:
  void check();

  std::vector<ros::Publisher> outputs_;
  std::uint32_t count_;
  std::function<void()> open_;
  ros::WallTime since_;
  ros::WallTimer timer_;
};

}  // namespace ratslam
