#include "ratslam_ros/support/run_node.h"

#include <ros/callback_queue.h>

#include "ratslam/common/stop_signal.h"

namespace ratslam {

void spinUntilStopped() {
  catchStopSignals();
  while (ros::ok() && !stopRequested()) ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
}

}  // namespace ratslam
