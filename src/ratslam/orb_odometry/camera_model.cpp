#include "ratslam/orb_odometry/camera_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "ratslam/common/params.h"

namespace ratslam {
namespace {

constexpr int kMaxNewtonSteps = 15;
constexpr double kNewtonTolerance = 1e-10;  // in bearing units: far below a thousandth of a pixel
constexpr double kJacobianStep = 1e-6;      // in bearing units

std::size_t coefficientCount(LensModel model) {
  switch (model) {
    case LensModel::kPlumbBob:
      return 5;
    case LensModel::kRationalPolynomial:
      return 8;
    case LensModel::kEquidistant:
      return 4;
    case LensModel::kNone:
      break;
  }
  return 0;
}

/// Distorted bearing of an ideal one.
Eigen::Vector2d distortBearing(const CameraModel& camera, const Eigen::Vector2d& ideal) {
  std::array<double, 8> k{};
  std::copy_n(camera.coefficients.begin(), std::min(camera.coefficients.size(), k.size()), k.begin());
  const double r2 = ideal.squaredNorm();
  if (camera.model == LensModel::kEquidistant) {
    const double r = std::sqrt(r2);
    if (r < 1e-12) return ideal;
    const double theta = std::atan(r);
    const double t2 = theta * theta;
    const double bent = theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
    return ideal * (bent / r);
  }
  const double x = ideal.x();
  const double y = ideal.y();
  const double radial =
      (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
  return {x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
          y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y};
}

Eigen::Matrix2d distortBearingJacobian(const CameraModel& camera, const Eigen::Vector2d& ideal) {
  Eigen::Matrix2d jacobian;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = kJacobianStep * Eigen::Vector2d::Unit(axis);
    jacobian.col(axis) =
        (distortBearing(camera, ideal + step) - distortBearing(camera, ideal - step)) / (2.0 * kJacobianStep);
  }
  return jacobian;
}

/// Where Newton's method starts. An equidistant lens is undone along its radius first: at wide angles the
/// tangent is too steep for a start at the distorted bearing itself.
Eigen::Vector2d firstGuess(const CameraModel& camera, const Eigen::Vector2d& bent) {
  if (camera.model != LensModel::kEquidistant) return bent;
  const double bent_angle = bent.norm();
  if (bent_angle < 1e-9) return bent;
  constexpr double kWidest = 1.5;  // [rad] of incidence that a pinhole can still represent
  return bent * (std::tan(std::min(bent_angle, kWidest)) / bent_angle);
}

}  // namespace

LensModel lensModelFromName(const std::string& name) {
  if (name.empty() || name == "none") return LensModel::kNone;
  if (name == "plumb_bob") return LensModel::kPlumbBob;
  if (name == "rational_polynomial") return LensModel::kRationalPolynomial;
  if (name == "equidistant" || name == "fisheye") return LensModel::kEquidistant;
  throwBadValue("distortion_model", name, "it must be plumb_bob, rational_polynomial, equidistant or none");
}

void CameraModel::validate() const {
  if (width < 1) throwBadValue("camera width", width, "it must be positive");
  if (height < 1) throwBadValue("camera height in pixels", height, "it must be positive");
  if (!(fx > 0.0) || !std::isfinite(fx)) throwBadValue("camera fx", fx, "it must be positive");
  if (!(fy > 0.0) || !std::isfinite(fy)) throwBadValue("camera fy", fy, "it must be positive");
  if (!std::isfinite(cx)) throwBadValue("camera cx", cx, "it must be finite");
  if (!std::isfinite(cy)) throwBadValue("camera cy", cy, "it must be finite");
  if (coefficients.size() > coefficientCount(model)) {
    throwBadValue("number of distortion coefficients", coefficients.size(),
                  "the lens model has " + std::to_string(coefficientCount(model)));
  }
  for (const double k : coefficients) {
    if (!std::isfinite(k)) throwBadValue("distortion coefficient", k, "it must be finite");
  }
}

Eigen::Vector2d CameraModel::undistort(const Eigen::Vector2d& raw) const {
  if (model == LensModel::kNone) return raw;
  const Eigen::Vector2d bent((raw.x() - cx) / fx, (raw.y() - cy) / fy);
  Eigen::Vector2d ideal = firstGuess(*this, bent);
  for (int step = 0; step < kMaxNewtonSteps; ++step) {
    const Eigen::Vector2d error = distortBearing(*this, ideal) - bent;
    if (!(error.squaredNorm() > kNewtonTolerance * kNewtonTolerance)) break;
    const Eigen::Matrix2d jacobian = distortBearingJacobian(*this, ideal);
    if (!(std::abs(jacobian.determinant()) > 1e-9)) break;
    ideal -= jacobian.inverse() * error;
  }
  if (!ideal.allFinite()) ideal = bent;
  return {fx * ideal.x() + cx, fy * ideal.y() + cy};
}

std::vector<Eigen::Vector2d> CameraModel::undistort(const std::vector<Eigen::Vector2d>& raw) const {
  std::vector<Eigen::Vector2d> pixels(raw.size());
  std::transform(raw.begin(), raw.end(), pixels.begin(), [&](const auto& point) { return undistort(point); });
  return pixels;
}

Eigen::Vector2d CameraModel::distort(const Eigen::Vector2d& pixel) const {
  if (model == LensModel::kNone) return pixel;
  const Eigen::Vector2d bent = distortBearing(*this, {(pixel.x() - cx) / fx, (pixel.y() - cy) / fy});
  return {fx * bent.x() + cx, fy * bent.y() + cy};
}

Eigen::Matrix2d CameraModel::distortJacobian(const Eigen::Vector2d& pixel) const {
  if (model == LensModel::kNone) return Eigen::Matrix2d::Identity();
  Eigen::Matrix2d jacobian = distortBearingJacobian(*this, {(pixel.x() - cx) / fx, (pixel.y() - cy) / fy});
  jacobian(0, 1) *= fx / fy;
  jacobian(1, 0) *= fy / fx;
  return jacobian;
}

CameraModel CameraModel::withRadialChange(const Eigen::Vector2d& change) const {
  CameraModel changed = *this;
  if (changed.model == LensModel::kNone) changed.model = LensModel::kPlumbBob;
  if (changed.coefficients.size() < 2) changed.coefficients.resize(2, 0.0);
  changed.coefficients[0] += change.x();
  changed.coefficients[1] += change.y();
  return changed;
}

}  // namespace ratslam
