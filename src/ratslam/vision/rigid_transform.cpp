#include "ratslam/vision/rigid_transform.h"

#include <cmath>

namespace ratslam {
namespace {

constexpr double kSmallAngle = 1e-4;  // below it, fourth-order series are exact to double precision

/// Left Jacobian of SO(3): translation of exp((v, omega)) is leftJacobian(omega) v.
Eigen::Matrix3d leftJacobian(const Eigen::Vector3d& omega) {
  const double angle = omega.norm();
  const Eigen::Matrix3d w = skew(omega);
  const double a2 = angle * angle;
  const double a = angle < kSmallAngle ? 0.5 - a2 / 24.0 : (1.0 - std::cos(angle)) / a2;
  const double b = angle < kSmallAngle ? 1.0 / 6.0 - a2 / 120.0 : (angle - std::sin(angle)) / (a2 * angle);
  return Eigen::Matrix3d::Identity() + a * w + b * w * w;
}

}  // namespace

Eigen::Quaterniond expRotation(const Eigen::Vector3d& omega) {
  const double angle = omega.norm();
  const double half = 0.5 * angle;
  const double factor = angle < kSmallAngle ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  const Eigen::Vector3d v = factor * omega;
  return Eigen::Quaterniond(std::cos(half), v.x(), v.y(), v.z()).normalized();
}

Eigen::Vector3d logRotation(const Eigen::Quaterniond& rotation) {
  const double sign =
      rotation.w() < 0.0 ? -1.0 : 1.0;  // q and -q are the same rotation; take the shorter one
  const Eigen::Vector3d v = sign * rotation.vec();
  const double sine = v.norm();
  const double w = sign * rotation.w();
  const double factor =
      sine < kSmallAngle ? 2.0 / w - 2.0 * sine * sine / (3.0 * w * w * w) : 2.0 * std::atan2(sine, w) / sine;
  return factor * v;
}

RigidTransform expTransform(const Vector6& twist) {
  const Eigen::Vector3d omega = twist.tail<3>();
  return {expRotation(omega), leftJacobian(omega) * twist.head<3>()};
}

Vector6 logTransform(const RigidTransform& transform) {
  const Eigen::Vector3d omega = logRotation(transform.rotation);
  Vector6 twist;
  twist.head<3>() = leftJacobian(omega).inverse() * transform.translation;
  twist.tail<3>() = omega;
  return twist;
}

}  // namespace ratslam
