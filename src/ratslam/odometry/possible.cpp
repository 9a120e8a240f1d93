#include "ratslam/odometry/possible.h"

#include <cmath>
#include <sstream>

#include "ratslam/odometry/odometry_timeline.h"

namespace ratslam {
namespace {

constexpr double kFastest = 1e6;    // [m/s], and [rad/s]
constexpr double kFarthest = 1e12;  // [m]

std::string beyond(const char* what, double value, double most, const char* unit) {
  if (!std::isfinite(value)) return std::string(what) + " is not finite";
  if (std::abs(value) <= most) return "";
  std::ostringstream text;
  text << what << " " << value << " " << unit << " is out of range: at most " << most;
  return text.str();
}

std::string beyond(const char* what, const Eigen::Isometry3d& pose) {
  if (!pose.linear().allFinite()) return std::string(what) + " is not finite";
  for (const double value : {pose.translation().x(), pose.translation().y(), pose.translation().z()}) {
    std::string why = beyond(what, value, kFarthest, "m");
    if (!why.empty()) return why;
  }
  return "";
}

std::string whyImpossible(const OdometryCorrection& correction) {
  if (!correction.covariance.allFinite()) return "the covariance of the correction is not finite";
  if (correction.covariance.diagonal().minCoeff() < 0.0) return "the correction has a negative variance";
  for (const StampedMotion& moved : correction.way) {
    std::string why = beyond("a position on the way of the correction", moved.motion);
    if (!why.empty()) return why;
  }
  return beyond("the motion of the correction", correction.motion);
}

}  // namespace

std::string whyImpossible(const OdometrySample& sample) {
  std::string why = beyond("the speed", sample.speed, kFastest, "m/s");
  if (why.empty()) why = beyond("the yaw rate", sample.yaw_rate, kFastest, "rad/s");
  if (why.empty() && sample.pose) why = beyond("the position", *sample.pose);
  if (why.empty() && sample.correction) why = whyImpossible(*sample.correction);
  const bool unit = !sample.unit || (std::isfinite(sample.unit->walk_sigma) &&
                                     std::isfinite(sample.unit->anchor_sigma.value_or(0.0)) &&
                                     std::isfinite(sample.unit->constant_sigma));
  if (why.empty() && !unit) why = "the uncertainty of the unit of length is not finite";
  return why;
}

std::string whyDropped(SampleVerdict verdict, const OdometrySample& sample) {
  if (verdict == SampleVerdict::kImpossible) return whyImpossible(sample);
  if (verdict == SampleVerdict::kRepeatedStamp) return "it repeats the stamp before it";
  if (verdict == SampleVerdict::kLate) return "it is older than the message before it";
  if (verdict == SampleVerdict::kAhead)
    return "its stamp " + formatStamp(sample.stamp) + " lies ahead of the messages before and after it";
  return "";
}

}  // namespace ratslam
