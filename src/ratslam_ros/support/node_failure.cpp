#include "ratslam_ros/support/node_failure.h"

#include <ros/console.h>

#include <atomic>

namespace ratslam {
namespace {

std::atomic<bool> process_is_shared{false};

}  // namespace

void setProcessIsShared() { process_is_shared = true; }

void failNode(const std::exception& error) {
  if (!process_is_shared) throw;
  ROS_FATAL("the nodelet stays idle: %s", error.what());
}

}  // namespace ratslam
