/// Which numbers an odometry can mean: what no machine drives would overflow once it is added up over a drive.
#pragma once

#include <string>

#include "ratslam/odometry/odometry.h"

namespace ratslam {

/// Why a sample cannot be used: a number that is not finite, or one beyond 10^6 m/s, 10^6 rad/s or 10^12 m. Empty where
/// it can. The covariance of the twist is not looked at: one that cannot be used counts as not said.
std::string whyImpossible(const OdometrySample& sample);

}  // namespace ratslam
