/// Subscriptions with guarded callbacks: an exception never ends a node. The message is dropped, counted, and reported
/// from time to time. So are messages that were lost in transport. Diagnostics show the counts once a second.
#pragma once

#include <ros/node_handle.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "ratslam_ros/support/checked_subscription.h"
#include "ratslam_ros/support/counted_warning.h"
#include "ratslam_ros/support/send_queue.h"

namespace ratslam {

/// Who numbers the messages of a topic in header.seq. Tools that thin out a stream keep the numbers that another
/// publisher gave, so that missing ones of a foreign stream mean nothing.
enum class Numbering { kOurs, kForeign };

class MessageGuard {
 public:
  /// Calls `action`, which processes a message of `topic`. @return false if it threw
  template <class Action>
  bool run(const std::string& topic, Action&& action) {
    try {
      action();
      return true;
    } catch (const std::exception& e) {
      dropped_[topic].report(topic + ": message dropped: " + e.what());
    }
    return false;
  }

  /// Subscribes with a handler that may throw. With an unbounded queue, lost messages of our nodes are reported.
  template <class Message, class Handler>
  ros::Subscriber subscribe(ros::NodeHandle& handle, const std::string& topic, std::uint32_t queue_size,
                            Handler handler, Numbering numbering = Numbering::kOurs) {
    using Event = ros::MessageEvent<const Message>;
    const std::string name = handle.resolveName(topic);
    const bool counts = queue_size == 0 && numbering == Numbering::kOurs;
    const auto callback = [this, name, handler, counts](const Event& event) {
      const Message& message = *event.getConstMessage();
      if (counts) number(name, event.getPublisherName(), message.header.seq);
      run(name, [&] { handler(message); });
    };
    const auto refused = [this, name](const std::string& why) {
      run(name, [&] { throw std::runtime_error(why); });
    };
    return subscribeChecked<Message>(handle, topic, queue_size, callback, refused);
  }

  /// Publishes the counts of dropped messages to /diagnostics from here on. @param part  name of the part of the node
  void publishCounts(const ros::NodeHandle& handle, const std::string& part = "messages");

  std::size_t dropped(const std::string& topic) const;
  /// Counts messages lost before this one, by the number that ROS gave it. @param seq  header.seq
  void number(const std::string& topic, const std::string& publisher, std::uint32_t seq);
  std::size_t lost(const std::string& topic) const;

 private:
  struct Losses {
    LossWatch watch;
    CountedWarning warning;
  };
  void publish();

  std::map<std::string, Losses> losses_;
  std::map<std::string, CountedWarning> dropped_;
  std::string part_;
  ros::Publisher diagnostics_;
  ros::WallTimer timer_;
};

}  // namespace ratslam
