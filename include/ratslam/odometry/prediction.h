/// How long an odometry predicts that the robot goes on as it did.
#pragma once

namespace ratslam {

/// Without measurements for longer, it counts as standing where it is, so that a robot that is parked before a dark or
/// frozen camera is not driven on without end. The covariance grows all the same.
constexpr double kLongestPrediction_s = 30.0;

}  // namespace ratslam
