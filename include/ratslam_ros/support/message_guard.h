/// Subscriptions with guarded callbacks: an exception never ends a node. The message is dropped, counted, and reported
/// from time to time. So are messages that were lost in transport. Diagnostics show the counts.
#pragma once

#include <ros/node_handle.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>

#include "ratslam_ros/support/checked_subscription.h"
#include "ratslam_ros/support/counted_warning.h"
#include "ratslam_ros/support/send_queue.h"
#include "ratslam_ros/support/status_updater.h"

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

  /// The counts of messages that were dropped or lost, for diagnostics.
  void describe(DiagnosticStatus& status) const;
  std::size_t dropped(const std::string& topic) const;
  /// Counts messages lost before this one, by the number that ROS gave it. @param seq  header.seq
  void number(const std::string& topic, const std::string& publisher, std::uint32_t seq);
  std::size_t lost(const std::string& topic) const;

 private:
  struct Losses {
    LossWatch watch;
    CountedWarning warning;
  };

  std::map<std::string, Losses> losses_;
  std::map<std::string, CountedWarning> dropped_;
};

}  // namespace ratslam
