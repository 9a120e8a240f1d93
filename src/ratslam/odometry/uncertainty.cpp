#include "ratslam/odometry/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace ratslam {
namespace {

/// Variances from here on mean "unknown" [m^2/s^2, rad^2/s^2].
constexpr double kUnknownVariance = 1e4;
/// Tolerance for rounding, relative to the variances: of the difference between the two halves of a covariance, and of a
/// covariance that exceeds the bound by its variances.
constexpr double kAsymmetry = 1e-3;

}  // namespace

std::string whyAbsurd(const TwistCovariance& covariance) {
  const auto entry = [&covariance](int row, int column) {
    std::ostringstream text;
    text << "(" << row << ", " << column << ") = " << covariance(row, column);
    return text.str();
  };
  for (int row = 0; row < 6; ++row) {
    if (covariance(row, row) < 0.0) return "the variance " + entry(row, row) + " is negative";
    for (int column = 0; column < 6; ++column) {
      if (!std::isfinite(covariance(row, column))) return entry(row, column) + " is not finite";
    }
  }
  for (const int axis : {0, 5}) {
    if (covariance(axis, axis) >= kUnknownVariance) {
      return "the variance " + entry(axis, axis) + " is beyond what an odometry can have";
    }
  }
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < row; ++column) {
      const double size = std::sqrt(covariance(row, row) * covariance(column, column));
      if (std::abs(covariance(row, column) - covariance(column, row)) > kAsymmetry * size) {
        return entry(row, column) + " differs from " + entry(column, row);
      }
      if (std::abs(covariance(row, column)) > (1.0 + kAsymmetry) * size) {
        return entry(row, column) + " is beyond what the variances " + entry(row, row) + " and " +
               entry(column, column) + " allow";
      }
    }
  }
  return "";
}

TwistCovariance bounded(const TwistCovariance& covariance) {
  constexpr double kGreatest = 0.99 * kUnknownVariance;
  const double largest = std::max(covariance(0, 0), covariance(5, 5));
  return largest > kGreatest ? TwistCovariance(kGreatest / largest * covariance) : covariance;
}

double yawOf(const Eigen::Isometry3d& pose) { return std::atan2(pose.linear()(1, 0), pose.linear()(0, 0)); }

Eigen::Quaterniond tiltOf(const Eigen::Isometry3d& pose) {
  return (Eigen::AngleAxisd(-yawOf(pose), Eigen::Vector3d::UnitZ()) * Eigen::Quaterniond(pose.linear()))
      .normalized();
}

StepCovariance stepCovariance(const TwistCovariance& covariance, const Eigen::Quaterniond& tilt, double dt) {
  TwistCovariance held = covariance;
  for (int axis = 1; axis < 5; ++axis) {
    if (held(axis, axis) < kUnknownVariance) continue;
    held.row(axis).setZero();
    held.col(axis).setZero();
  }
  const Eigen::Matrix3d level = tilt.toRotationMatrix();
  Eigen::Matrix<double, 4, 6> by_twist = Eigen::Matrix<double, 4, 6>::Zero();
  by_twist.topLeftCorner<3, 3>() = dt * level;
  by_twist.bottomRightCorner<1, 3>() = dt * level.row(2);
  const StepCovariance result = by_twist * held * by_twist.transpose();
  return 0.5 * (result + result.transpose());
}

}  // namespace ratslam
