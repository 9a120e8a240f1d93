#include "ratslam/odometry/odometry_doubts.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "ratslam/common/angles.h"
#include "ratslam/odometry/possible.h"
#include "ratslam/odometry/uncertainty.h"

namespace ratslam {
namespace {

constexpr double kLongestStep_s = 2.0;  // over a longer one a twist may have changed
constexpr int kLeastSteps = 20;

/// Motion to the side matters if it is this share of that forward, and so long [m]. Noise and the arc of a base_link that
/// does not lie on the axis of turning do not count.
constexpr double kShareOfSide = 0.2;
constexpr double kLeastSide = 0.3;
constexpr double kNoise = 0.02;  // [m/s]
constexpr double kLever = 0.5;   // distance from the axis [m]

/// Slip and calibration do not change a way by this factor. Units do: 57 (degrees) or 1000 (millimetres).
constexpr double kAnotherUnit = 10.0;
constexpr double kLeastWay = 0.01;   // of the pose [m]
constexpr double kLeastTurn = 0.05;  // of the pose [rad]

double sideOf(double way, double turned, double dt) {
  if (!std::isfinite(way)) return 0.0;
  return std::max(0.0, std::abs(way) - kLever * std::abs(turned) - kNoise * dt);
}

}  // namespace

std::vector<std::string> OdometryDoubts::add(const OdometrySample& sample) {
  std::vector<std::string> doubts;
  const double dt = last_ ? secondsBetween(last_->stamp, sample.stamp) : 0.0;
  if (dt > 0.0 && dt <= kLongestStep_s && sample.epoch == last_->epoch) {
    twist_forward_ += std::abs(sample.speed) * dt;
    twist_left_ += sideOf(sample.sideways * dt, sample.yaw_rate * dt, dt);
    if (sample.pose && last_->pose && !sample.correction) addPose(sample, dt);
    for (const auto& doubt : {twistSideways(sample), poseSideways(), anotherUnit()}) {
      if (doubt) doubts.push_back(*doubt);
    }
  }
  last_ = sample;
  return doubts;
}

void OdometryDoubts::addPose(const OdometrySample& sample, double dt) {
  const double yaw = yawOf(*last_->pose);
  const double turned = wrapAngle(yawOf(*sample.pose) - yaw);
  const double middle = yaw + 0.5 * turned;
  const Eigen::Vector3d moved = sample.pose->translation() - last_->pose->translation();
  pose_forward_ += std::abs(std::cos(middle) * moved.x() + std::sin(middle) * moved.y());
  pose_left_ += sideOf(std::cos(middle) * moved.y() - std::sin(middle) * moved.x(), turned, dt);
  pose_way_ += moved.norm();
  pose_turn_ += std::abs(turned);
  twist_way_ += std::abs(sample.speed) * dt;
  twist_turn_ += std::abs(sample.yaw_rate) * dt;
  if (moved_ < kLeastSteps && (moved.norm() > 0.0 || turned != 0.0)) ++moved_;
}

std::optional<std::string> OdometryDoubts::twistSideways(const OdometrySample& sample) {
  if (said_twist_sideways_ || twist_left_ < kLeastSide || twist_left_ < kShareOfSide * twist_forward_ ||
      sample.sideways == 0.0)
    return std::nullopt;
  said_twist_sideways_ = true;
  std::ostringstream text;
  text << "linear.y is not used, and it is " << sample.sideways << " m/s at " << formatStamp(sample.stamp)
       << ": pose cells, and a map without exp_height, move forward only, by linear.x; the robot must turn "
          "to where it drives";
  return text.str();
}

std::optional<std::string> OdometryDoubts::poseSideways() {
  if (said_pose_sideways_ || said_twist_sideways_ || moved_ < kLeastSteps || pose_left_ < kLeastSide ||
      pose_left_ < pose_forward_ || twist_way_ > kShareOfSide * pose_left_)
    return std::nullopt;
  said_pose_sideways_ = true;
  std::ostringstream text;
  text << "the pose moves to the side, " << pose_left_ << " m so far, and " << pose_forward_
       << " m forward: only motion forward is used; the x axis of the pose must point to where the robot "
          "drives";
  return text.str();
}

std::optional<std::string> OdometryDoubts::anotherUnit() {
  if (said_unit_ || moved_ < kLeastSteps) return std::nullopt;
  const bool way = pose_way_ > kLeastWay && twist_way_ > kAnotherUnit * pose_way_;
  const bool turn = pose_turn_ > kLeastTurn && twist_turn_ > kAnotherUnit * pose_turn_;
  if (!way && !turn) return std::nullopt;
  said_unit_ = true;
  std::ostringstream text;
  if (way) {
    text << "the twist drives " << twist_way_ << " m where the pose moves " << pose_way_
         << " m: is linear.x in m/s?";
  } else {
    text << "the twist turns " << twist_turn_ << " rad where the pose turns " << pose_turn_
         << " rad: is angular.z in rad/s?";
  }
  text << " The map follows the twist";
  return text.str();
}

}  // namespace ratslam
