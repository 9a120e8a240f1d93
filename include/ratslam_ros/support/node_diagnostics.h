/// A node's state on /diagnostics, once a second, by diagnostic_updater: the state of each part, and memory.
#pragma once

#include <functional>
#include <string>

#include "ratslam/experience_map/experience_graph.h"
#include "ratslam_ros/support/image_subscriber.h"
#include "ratslam_ros/support/message_guard.h"
#include "ratslam_ros/support/status_updater.h"

namespace ratslam {

/// Rate of events [1/s] from a growing count, between two calls.
class RateMeter {
 public:
  double perSecond(std::size_t count);

 private:
  ros::WallTime looked_at_;
  std::size_t count_ = 0;
};

class NodeDiagnostics {
 public:
  /// @param own  handle of the node's private names; the namespace of these names it in diagnostics
  NodeDiagnostics(const ros::NodeHandle& handle, const ros::NodeHandle& own);

  /// @param name  of the part   @param describe  sets level, words and values
  void add(const std::string& name, std::function<void(DiagnosticStatus&)> describe);
  /// The stream of images: rate, drops, delay, age. A warning if images were dropped or skipped since the last time.
  void addImages(const ImageSubscriber& images);

  /// The messages that were dropped or lost. @param name  of the part
  void addMessages(const std::string& name, const MessageGuard& messages);

  /// To be called once a second of wall time.
  void publish() { updater_.force_update(); }

 private:
  StatusUpdater updater_;
};

/// Size of the map.
void describeMap(DiagnosticStatus& status, const ExperienceGraph& graph);

/// Physical memory of this process [MB]; 0 if unknown.
double residentMegabytes();

}  // namespace ratslam
