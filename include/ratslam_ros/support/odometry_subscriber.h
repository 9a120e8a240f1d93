/// Odometry from a topic into a stage of the pipeline: nothing is dropped by a queue, and what the stage
/// refuses is counted and reported. A sample that cannot be processed never ends a node (message_guard.h).
///
/// What a sample says of itself beyond nav_msgs/Odometry comes on a topic beside it (odom -> odom_quality).
/// Where somebody advertises that topic when the first sample comes, every sample waits for its quality
/// (quality_pairing.h); a silence of sync_timeout says that it was lost on the way.
#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>

#include <functional>
#include <optional>
#include <string>

#include "ratslam/odometry/odometry_timeline.h"
#include "ratslam_ros/OdometryQuality.h"
#include "ratslam_ros/support/counted_warning.h"
#include "ratslam_ros/support/message_guard.h"
#include "ratslam_ros/support/quality_pairing.h"
#include "ratslam_ros/support/stream_watch.h"

namespace ratslam {

class OdometrySubscriber {
 public:
  /// Hands a sample to the stage and says what became of it.
  using Handler = std::function<SampleVerdict(const OdometrySample&)>;

  /// @param sync_timeout  wall time after which samples go on without their quality [s]
  OdometrySubscriber(const ros::NodeHandle& handle, const std::string& topic, double sync_timeout,
                     Handler handler);

  void start();
  /// To be called every now and then: warns of what never came, and gives up waiting.
  void watchStreams();
  const std::string& topic() const { return watch_.topic(); }
  /// Frame of the poses as the messages name it, without the leading slash that tf once had; empty before the first.
  const std::string& frame() const { return frame_; }

 private:
  void onQuality(const ratslam_ros::OdometryQuality& message);
  void onSample(const nav_msgs::Odometry& message);
  /// Hands on the samples whose quality is known; all of them where `wait` is false.
  void drain(bool wait);
  void handOn(const OdometrySample& sample);

  ros::NodeHandle handle_;
  Handler handler_;
  StreamWatch watch_;
  std::string frame_;
  MessageGuard guard_;
  std::optional<bool> with_quality_;  ///< once the first sample has come
  QualityPairing pairing_;
  std::optional<std::uint32_t> epoch_;  ///< of the sample before
  SyncTimeout silence_;
  CountedWarning started_anew_;
  CountedWarning without_quality_;
  CountedWarning impossible_;
  CountedWarning repeated_;
  CountedWarning late_;
  CountedWarning absurd_;
  CountedWarning time_went_back_;
  ros::Subscriber quality_subscriber_;
  ros::Subscriber subscriber_;
};

}  // namespace ratslam
