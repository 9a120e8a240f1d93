#include "ratslam_ros/support/spin.h"

#include <ros/callback_queue.h>
#include <ros/init.h>

#include <csignal>

namespace ratslam {
namespace {

volatile std::sig_atomic_t interrupted = 0;  // a signal handler can reach nothing else

}  // namespace

void spinUntilInterrupted() {
  std::signal(SIGINT, [](int) { interrupted = 1; });
  while (ros::ok() && interrupted == 0) ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
}

}  // namespace ratslam
