/// Range check of odometry samples. Values that no machine can drive would overflow when they add up over a drive.
#pragma once

#include <string>

#include "ratslam/odometry/odometry.h"

namespace ratslam {

enum class SampleVerdict;

/// Why a sample cannot be used: a number is not finite, or beyond 10^6 m/s, 10^6 rad/s or 10^12 m. Empty if it can
/// be used. The covariance of the twist is not checked here: an unusable one counts as unknown.
std::string whyImpossible(const OdometrySample& sample);

/// Why a timeline has dropped a sample, as a sentence without its subject; empty if it has not.
std::string whyDropped(SampleVerdict verdict, const OdometrySample& sample);

}  // namespace ratslam
