/// diagnostic_updater's Updater and DiagnosticStatusWrapper. Where that package is missing, as in Ubuntu 20.04's own
/// archive, the part of them that the nodes use.
#pragma once

#if __has_include(<diagnostic_updater/diagnostic_updater.h>)

#include <diagnostic_updater/diagnostic_updater.h>

namespace ratslam {

using DiagnosticStatus = diagnostic_updater::DiagnosticStatusWrapper;
using StatusUpdater = diagnostic_updater::Updater;

}  // namespace ratslam

#else

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/ros.h>

#include <cstdarg>
#include <cstdio>
#include <functional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace ratslam {

/// Level, words and values of a node's part.
class DiagnosticStatus : public diagnostic_msgs::DiagnosticStatus {
 public:
  void summary(unsigned char new_level, const std::string& words) {
    level = new_level;
    message = words;
  }
  /// The same with words that are formatted as by printf.
  __attribute__((format(printf, 3, 4))) void summaryf(unsigned char new_level, const char* format, ...) {
    char words[1000];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(words, sizeof(words), format, arguments);
    va_end(arguments);
    summary(new_level, words);
  }
  template <class T>
  void add(const std::string& key, const T& value) {
    std::ostringstream text;
    text << value;
    diagnostic_msgs::KeyValue entry;
    entry.key = key;
    entry.value = text.str();
    values.push_back(entry);
  }
};

/// Publishes the states of a node's parts on /diagnostics.
class StatusUpdater {
 public:
  /// @param node_name  is put before the names of the parts
  StatusUpdater(ros::NodeHandle handle, const ros::NodeHandle& /*own*/, const std::string& node_name)
      : publisher_(handle.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 1)),
        node_name_(node_name.substr(node_name.find_first_not_of('/'))) {}

  void setHardwareID(const std::string& id) { hardware_id_ = id; }
  void add(const std::string& name, std::function<void(DiagnosticStatus&)> describe) {
    parts_.emplace_back(name, std::move(describe));
  }
  /// Publishes now.
  void force_update() {
    diagnostic_msgs::DiagnosticArray array;
    array.header.stamp = ros::Time::now();
    for (const auto& [name, describe] : parts_) {
      DiagnosticStatus status;
      status.name = node_name_ + ": " + name;
      status.hardware_id = hardware_id_;
      describe(status);
      array.status.push_back(status);
    }
    publisher_.publish(array);
  }

 private:
  ros::Publisher publisher_;
  std::string node_name_;
  std::string hardware_id_;
  std::vector<std::pair<std::string, std::function<void(DiagnosticStatus&)> > > parts_;
};

}  // namespace ratslam

#endif
