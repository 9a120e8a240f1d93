/// Odometry from a topic into a stage of the pipeline: nothing is dropped by a queue, and what the stage
/// refuses is counted and reported.
#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <string>

#include "ratslam/odometry/odometry_timeline.h"
#include "ratslam_ros/support/counted_warning.h"
#include "ratslam_ros/support/stream_watch.h"

namespace ratslam {

class OdometrySubscriber {
 public:
  /// Hands a sample to the stage and says what became of it.
  using Handler = std::function<SampleVerdict(const OdometrySample&)>;

  OdometrySubscriber(const ros::NodeHandle& handle, const std::string& topic, Handler handler);

  void start();
  StreamWatch& watch() { return watch_; }

 private:
  ros::NodeHandle handle_;
  Handler handler_;
  StreamWatch watch_;
  CountedWarning not_finite_;
  CountedWarning repeated_;
  CountedWarning time_went_back_;
  ros::Subscriber subscriber_;
};

}  // namespace ratslam
