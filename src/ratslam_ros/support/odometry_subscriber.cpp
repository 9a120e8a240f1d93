#include "ratslam_ros/support/odometry_subscriber.h"

#include "ratslam/odometry/possible.h"
#include "ratslam/odometry/uncertainty.h"
#include "ratslam_ros/support/conversions.h"

namespace ratslam {
OdometrySubscriber::OdometrySubscriber(const ros::NodeHandle& handle, const std::string& topic,
                                       double sync_timeout, Handler handler)
    : handle_(handle),
      handler_(std::move(handler)),
      watch_(handle.resolveName(topic), "nav_msgs/Odometry"),
      silence_(sync_timeout) {}

void OdometrySubscriber::start() {
  watch_.start();
  quality_subscriber_ = guard_.subscribe<ratslam_ros::OdometryQuality>(
      handle_, watch_.topic() + "_quality", 0,
      [this](const ratslam_ros::OdometryQuality& message) { onQuality(message); });
  subscriber_ = guard_.subscribe<nav_msgs::Odometry>(
      handle_, watch_.topic(), 0, [this](const nav_msgs::Odometry& message) { onSample(message); },
      Numbering::kForeign);
}

void OdometrySubscriber::watchStreams() {
  watch_.warnIfItNeverCame();
  if (!silence_.expired(pairing_.waits())) return;
  without_quality_.report(watch_.topic() + "_quality is silent: odometry is taken without it");
  guard_.run(watch_.topic(), [this] { drain(false); });
}

void OdometrySubscriber::onQuality(const ratslam_ros::OdometryQuality& message) {
  with_quality_ = true;
  silence_.messageArrived();
  requireUsable(message);
  pairing_.hearQuality(message);
  drain(true);
}

void OdometrySubscriber::onSample(const nav_msgs::Odometry& message) {
  watch_.messageArrived();
  frame_ = message.header.frame_id;
  if (!frame_.empty() && frame_.front() == '/') frame_.erase(0, 1);
  if (!with_quality_) with_quality_ = isPublished(watch_.topic() + "_quality");
  pairing_.hearSample(odometryFromMessage(message));
  drain(with_quality_.value_or(false));
}

void OdometrySubscriber::drain(bool wait) {
  while (const std::optional<OdometrySample> sample = pairing_.next(wait)) handOn(*sample);
}

void OdometrySubscriber::handOn(const OdometrySample& sample) {
  if (epoch_ && *epoch_ != sample.epoch) {
    started_anew_.report(watch_.topic() +
                         ": its source started anew, how far it went before that is not known");
  }
  epoch_ = sample.epoch;
  if (sample.covariance && absurd_.count() == 0) {
    const std::string absurdity = whyAbsurd(*sample.covariance);
    if (!absurdity.empty()) {
      absurd_.report(watch_.topic() + ": covariances that cannot be used count as not said: " + absurdity);
    }
  }
  for (const std::string& doubt : doubts_.add(sample))
    ROS_WARN("%s: %s", watch_.topic().c_str(), doubt.c_str());
  for (const DecidedSample& decided : handler_(sample)) report(decided);
}

void OdometrySubscriber::report(const DecidedSample& decided) {
  const std::string dropped = watch_.topic() + ": odometry dropped";
  const std::string why = whyDropped(decided.verdict, decided.sample);
  switch (decided.verdict) {
    case SampleVerdict::kAccepted:
    case SampleVerdict::kHeld:
      break;
    case SampleVerdict::kAhead:
      ahead_.report(dropped + ", " + why);
      break;
    case SampleVerdict::kImpossible:
      impossible_.report(dropped + ": " + why);
      break;
    case SampleVerdict::kRepeatedStamp:
      repeated_.report(dropped + ", " + why);
      break;
    case SampleVerdict::kLate:
      late_.report(dropped + ", " + why);
      break;
    case SampleVerdict::kTimeWentBack:
      time_went_back_.report(watch_.topic() +
                             ": time went back, the stream starts anew once the images have " +
                             "gone back, too (or has the topic a second publisher?)");
      break;
  }
}

}  // namespace ratslam
