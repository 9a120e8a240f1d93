/// Keeps an eye on the streams a node lives on: one that never comes, and one that falls silent while another
/// waits for it.
#pragma once

#include <ros/master.h>
#include <ros/time.h>

#include <optional>
#include <string>
#include <vector>

namespace ratslam {

/// Whether the ROS master knows a publisher of that topic, a resolved name.
bool isPublished(const std::string& topic);

/// Topics somebody publishes that may be meant by `topic`: of the same type, or whose name ends alike. The same
/// images in another transport come first, with the parameter that reads them; pictures that nodes of this package
/// draw are none.
std::vector<std::string> similarTopics(const std::string& topic, const std::string& type,
                                       const std::vector<ros::master::TopicInfo>& published);

/// A subscription that should bring messages.
class StreamWatch {
 public:
  /// @param topic  resolved name   @param type  data type, such as nav_msgs/Odometry
  StreamWatch(std::string topic, std::string type) : topic_(std::move(topic)), type_(std::move(type)) {}

  void start() { started_ = ros::WallTime::now(); }
  void messageArrived() { came_ = true; }
  bool came() const { return came_; }
  const std::string& topic() const { return topic_; }

  /// Warns once when nothing has come for 5 s after start(), with the topics that look like it.
  void warnIfItNeverCame();

 private:
  std::string topic_;
  std::string type_;
  std::optional<ros::WallTime> started_;
  bool came_ = false;
  bool warned_ = false;
};

/// Decides when a stream whose messages wait goes on without the stream they wait for.
///
/// Silence counts in wall time, and where a simulated clock runs in that too: a paused player is not silence.
/// Once given up, the silent stream is not waited for until it speaks again.
class SyncTimeout {
 public:
  explicit SyncTimeout(double timeout_s) : timeout_s_(timeout_s) {}

  /// The stream that is waited for has spoken, or what waited has been processed after all.
  void messageArrived() {
    waiting_since_.reset();
    given_up_ = false;
  }

  /// @return true where what waits shall be processed now. To be asked every now and then.
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
