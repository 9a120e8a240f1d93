/// Rigid motion of space, SE(3): a unit quaternion and a translation. The quaternion is normalised at each product,
/// so that long products stay orthogonal.
///
/// Exponential and logarithm after Barfoot, State Estimation for Robotics (2017), ch. 7; twists are ordered
/// (translation, rotation).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ratslam {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Cross-product matrix: skew(a) b = a x b.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// x -> rotation * x + translation.
struct RigidTransform {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return rotation * x + translation; }
  RigidTransform operator*(const RigidTransform& other) const {
    return {(rotation * other.rotation).normalized(), rotation * other.translation + translation};
  }
  RigidTransform inverse() const {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation)};
  }
  Eigen::Isometry3d isometry() const {
    Eigen::Isometry3d m = Eigen::Isometry3d::Identity();
    m.linear() = rotation.toRotationMatrix();
    m.translation() = translation;
    return m;
  }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("rotation", rotation);
    fields("translation", translation);
  }
};

/// Rotation of |omega| [rad] about omega.
Eigen::Quaterniond expRotation(const Eigen::Vector3d& omega);
/// The rotation vector of a unit quaternion, of length in [0, pi].
Eigen::Vector3d logRotation(const Eigen::Quaterniond& rotation);
/// The motion by a constant twist (translation, rotation) in unit time.
RigidTransform expTransform(const Vector6& twist);
/// The twist whose exponential is `transform`.
Vector6 logTransform(const RigidTransform& transform);

}  // namespace ratslam
