#include "ratslam/experience_map/solver/uncertain_pose.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace ratslam {
namespace {

Eigen::Vector4d asVector(const RelativePose& pose) { return {pose.x, pose.y, pose.z, pose.yaw}; }

Eigen::Matrix4d inverseOf(const Eigen::Matrix4d& covariance) {
  return covariance.llt().solve(Eigen::Matrix4d::Identity());
}

}  // namespace

Eigen::Matrix4d turnedAxes(double yaw) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<2, 2>() << std::cos(yaw), -std::sin(yaw), std::sin(yaw), std::cos(yaw);
  return matrix;
}

UncertainPose joined(const UncertainPose& a, const UncertainPose& b) {
  const Eigen::Matrix4d by_b = turnedAxes(a.pose.yaw);
  const Eigen::Vector4d moved = by_b * Eigen::Vector4d(b.pose.x, b.pose.y, b.pose.z, 0.0);
  Eigen::Matrix4d by_a = Eigen::Matrix4d::Identity();
  by_a(0, 3) = -moved.y();
  by_a(1, 3) = moved.x();
  UncertainPose both;
  both.pose = {a.pose.x + moved.x(), a.pose.y + moved.y(), a.pose.z + moved.z(),
               wrapAngle(a.pose.yaw + b.pose.yaw)};
  both.covariance = by_a * a.covariance * by_a.transpose() + by_b * b.covariance * by_b.transpose();
  return both;
}

UncertainPose inverted(const UncertainPose& a) {
  const Eigen::Matrix4d back = turnedAxes(-a.pose.yaw);
  const Eigen::Vector4d start = -(back * Eigen::Vector4d(a.pose.x, a.pose.y, a.pose.z, 0.0));
  Eigen::Matrix4d by_a = -back;
  by_a(0, 3) = start.y();
  by_a(1, 3) = -start.x();
  UncertainPose inverse;
  inverse.pose = {start.x(), start.y(), start.z(), wrapAngle(-a.pose.yaw)};
  inverse.covariance = by_a * a.covariance * by_a.transpose();
  return inverse;
}

UncertainPose combined(const UncertainPose& a, const UncertainPose& b) {
  Eigen::Vector4d apart = asVector(b.pose) - asVector(a.pose);
  apart[3] = wrapAngle(apart[3]);
  UncertainPose both;
  both.covariance = inverseOf(inverseOf(a.covariance) + inverseOf(b.covariance));
  const Eigen::Vector4d moved = both.covariance * (inverseOf(b.covariance) * apart);
  both.pose = {a.pose.x + moved[0], a.pose.y + moved[1], a.pose.z + moved[2],
               wrapAngle(a.pose.yaw + moved[3])};
  return both;
}

}  // namespace ratslam
