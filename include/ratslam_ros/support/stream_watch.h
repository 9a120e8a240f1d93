/// Watches the input streams of a node: one that never comes, and one that becomes silent while another waits for it.
#pragma once

#include <ros/master.h>
#include <ros/time.h>

#include <optional>
#include <string>
#include <vector>

namespace ratslam {

/// Whether the ROS master knows a publisher of a topic. @param topic  resolved name
/// @return none if the master does not answer
std::optional<bool> isPublished(const std::string& topic);

/// Published topics that may be meant by `topic`: of the same type, or with the same last name. The same images in
/// another transport, and the topic itself with another type, come first, with what to do. Pictures drawn by nodes of this package are left
/// out.
std::vector<std::string> similarTopics(const std::string& topic, const std::string& type,
                                       const std::vector<ros::master::TopicInfo>& published);

/// Watches a subscription for which messages are expected.
class StreamWatch {
 public:
  /// @param topic  resolved name   @param type  data type, such as nav_msgs/Odometry
  StreamWatch(std::string topic, std::string type) : topic_(std::move(topic)), type_(std::move(type)) {}

  void start() { started_ = ros::WallTime::now(); }
  void messageArrived() { came_ = true; }
  bool came() const { return came_; }
  const std::string& topic() const { return topic_; }

  /// Warns once if nothing has come for 5 s after start(), and lists similar topics.
  void warnIfItNeverCame();

 private:
  std::string topic_;
  std::string type_;
  std::optional<ros::WallTime> started_;
  bool came_ = false;
  bool warned_ = false;
};

/// Decides when waiting messages are processed without the stream for which they wait.
///
/// Silence is measured in wall time and, with a simulated clock, in simulated time too: a paused player does not count
/// as silence. After a timeout, messages do not wait until the silent stream continues.
class SyncTimeout {
 public:
  explicit SyncTimeout(double timeout_s) : timeout_s_(timeout_s) {}

  /// To be called when the other stream has brought a message, or the waiting messages have been processed.
  void messageArrived() {
    waiting_since_.reset();
    given_up_ = false;
  }

  /// @return true if the waiting messages are to be processed now. To be called regularly.
  bool expired(bool something_waits);

 private:
  struct Clocks {
    ros::WallTime wall;
    ros::Time ros;
  };

  double timeout_s_;
  std::optional<Clocks> waiting_since_;
  bool given_up_ = false;
};

}  // namespace ratslam
