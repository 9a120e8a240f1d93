/// Passes odometry from a topic to a stage of the pipeline. No queue drops samples. Samples that the stage refuses are
/// counted and reported. A sample that cannot be processed never ends a node (message_guard.h).
///
/// The quality of a sample comes on a topic beside it (odom -> odom_quality). If that topic is advertised when the first
/// sample comes, every sample waits for its quality (quality_pairing.h). After sync_timeout without any the quality is
/// taken as lost.
#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/odometry/odometry_doubts.h"
#include "ratslam/system/event_gate.h"
#include "ratslam_ros/OdometryQuality.h"
#include "ratslam_ros/support/counted_warning.h"
#include "ratslam_ros/support/message_guard.h"
#include "ratslam_ros/support/quality_pairing.h"
#include "ratslam_ros/support/stream_watch.h"

namespace ratslam {

/// Adds a sample to a stage. @return the stage's verdicts on a sample that was held and on this one
template <class Stage>
std::vector<DecidedSample> addTo(Stage& stage, const OdometrySample& sample) {
  const SampleVerdict verdict = stage.addOdometry(sample);
  std::vector<DecidedSample> verdicts = stage.takeDecided();
  verdicts.push_back({sample, verdict});
  return verdicts;
}

class OdometrySubscriber {
 public:
  /// Hands a sample to the stage. @return the stage's verdicts on a sample that was held and on this one
  using Handler = std::function<std::vector<DecidedSample>(const OdometrySample&)>;

  /// @param sync_timeout  wall time after which samples go on without their quality [s]
  OdometrySubscriber(const ros::NodeHandle& handle, const std::string& topic, double sync_timeout,
                     Handler handler);

  void start();
  /// To be called regularly. Warns about missing messages, and ends the waiting after sync_timeout.
  void watchStreams();
  /// For diagnostics.
  const MessageGuard& messages() const { return guard_; }
  const std::string& topic() const { return watch_.topic(); }
  /// Frame of the poses in the messages, without the leading slash of old tf names; empty before the first message.
  const std::string& frame() const { return frame_; }

 private:
  void onQuality(const ratslam_ros::OdometryQuality& message);
  void onSample(const nav_msgs::Odometry& message);
  /// Hands on the samples whose quality is known; all of them if `wait` is false.
  void drain(bool wait);
  void handOn(const OdometrySample& sample);
  void report(const DecidedSample& decided);

  ros::NodeHandle handle_;
  Handler handler_;
  StreamWatch watch_;
  std::string frame_;
  MessageGuard guard_;
  std::optional<bool> with_quality_;  ///< once the first sample has come
  QualityPairing pairing_;
  std::optional<std::uint32_t> epoch_;  ///< of the sample before
  SyncTimeout silence_;
  OdometryDoubts doubts_;
  CountedWarning started_anew_;
  CountedWarning without_quality_;
  CountedWarning impossible_;
  CountedWarning repeated_;
  CountedWarning late_;
  CountedWarning ahead_;
  CountedWarning absurd_;
  CountedWarning time_went_back_;
  ros::Subscriber quality_subscriber_;
  ros::Subscriber subscriber_;
};

}  // namespace ratslam
