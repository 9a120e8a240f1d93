#include "ratslam/camera/camera_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "ratslam/common/params.h"

namespace ratslam {
namespace {

constexpr double kMinFocal = 1e-3;  // [px]
constexpr double kMaxFocal = 1e6;
constexpr double kMaxSize = 65535;
constexpr int kMaxNewtonSteps = 15;
constexpr double kNewtonTolerance = 1e-10;  // squared length of a step, in bearing units

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

/// A distorted bearing and its derivative by the ideal bearing.
struct BentBearing {
  Eigen::Vector2d bearing;
  Eigen::Matrix2d jacobian;
};

using Coefficients = std::array<double, 8>;  // missing ones are zero

Coefficients coefficientsOf(const CameraModel& camera) {
  Coefficients k{};
  for (std::size_t i = 0; i < std::min(camera.coefficients.size(), k.size()); ++i)
    k[i] = camera.coefficients[i];
  return k;
}

BentBearing bendEquidistant(const Coefficients& k, const Eigen::Vector2d& ideal) {
  const double r2 = ideal.squaredNorm();
  const double r = std::sqrt(r2);
  if (r < 1e-12) return {ideal, Eigen::Matrix2d::Identity()};
  const double theta = std::atan(r);
  const double t2 = theta * theta;
  const double bent = theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  const double bent_by_theta =
      1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])));
  const double scale = bent / r;
  const double scale_by_r = (bent_by_theta / (1.0 + r2) - scale) / r;
  return {ideal * scale, scale * Eigen::Matrix2d::Identity() + scale_by_r / r * ideal * ideal.transpose()};
}

inline BentBearing bend(LensModel model, const Coefficients& k, const Eigen::Vector2d& ideal) {
  if (model == LensModel::kEquidistant) return bendEquidistant(k, ideal);
  const double x = ideal.x();
  const double y = ideal.y();
  const double r2 = ideal.squaredNorm();
  double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  double radial_by_r2 = k[0] + r2 * (2.0 * k[1] + r2 * 3.0 * k[4]);
  if (model == LensModel::kRationalPolynomial) {
    const double below = 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
    const double below_by_r2 = k[5] + r2 * (2.0 * k[6] + r2 * 3.0 * k[7]);
    radial /= below;
    radial_by_r2 = (radial_by_r2 - radial * below_by_r2) / below;
  }
  BentBearing bent;
  bent.bearing = {x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
                  y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y};
  const double across = 2.0 * (x * y * radial_by_r2 + k[2] * x + k[3] * y);
  bent.jacobian << radial + 2.0 * (x * x * radial_by_r2 + k[2] * y + 3.0 * k[3] * x), across,  //
      across, radial + 2.0 * (y * y * radial_by_r2 + 3.0 * k[2] * y + k[3] * x);
  return bent;
}

/// Start of Newton's method. For an equidistant lens the radius is inverted first, because at wide angles the tangent is
/// too steep for a start at the distorted bearing itself.
Eigen::Vector2d firstGuess(const CameraModel& camera, const Eigen::Vector2d& bent) {
  if (camera.model != LensModel::kEquidistant) return bent;
  const double bent_angle = bent.norm();
  if (bent_angle < 1e-9) return bent;
  constexpr double kWidest = 1.5;  // largest angle of incidence that a pinhole can represent [rad]
  return bent * (std::tan(std::min(bent_angle, kWidest)) / bent_angle);
}

/// A pixel that is distorted too much for a real lens, half-way to a corner; none if the coefficients are plausible.
std::optional<Eigen::Vector2d> pixelBentTooFar(const CameraModel& camera) {
  constexpr double kUndone = 1.0;  // [px]
  constexpr double kMostBent = 5.0;
  const Eigen::Vector2d middle(camera.cx, camera.cy);
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(camera.width, 0), Eigen::Vector2d(0, camera.height),
        Eigen::Vector2d(camera.width, camera.height)}) {
    const Eigen::Vector2d raw = 0.5 * (middle + corner);
    const Eigen::Vector2d pixel = camera.undistort(raw);
    // Component in the direction of the raw pixel. With a wrong sign of coefficients the pixel may be on the other side.
    const double farther = (pixel - middle).dot(raw - middle) / (raw - middle).squaredNorm();
    const bool undone = (camera.distort(pixel) - raw).norm() < kUndone;
    if (!undone || !(farther * kMostBent > 1.0 && farther < kMostBent)) return raw;
  }
  return std::nullopt;
}

}  // namespace

LensModel lensModelFromName(const std::string& name) {
  if (name.empty() || name == "none") return LensModel::kNone;
  if (name == "plumb_bob") return LensModel::kPlumbBob;
  if (name == "rational_polynomial") return LensModel::kRationalPolynomial;
  if (name == "equidistant" || name == "fisheye") return LensModel::kEquidistant;
  const bool printable = std::all_of(name.begin(), name.end(), [](char c) { return c >= ' ' && c < '\x7f'; });
  const std::string shown = printable ? name : "of " + std::to_string(name.size()) + " unprintable bytes";
  throwBadValue("distortion_model", shown, "it must be plumb_bob, rational_polynomial, equidistant or none");
}

void CameraModel::validate() const {
  const auto within = [](const char* key, double value, double lowest, double highest) {
    if (value >= lowest && value <= highest) return;
    std::ostringstream requirement;
    requirement << "it must lie within [" << lowest << ", " << highest << "] px";
    throwBadValue(key, value, requirement.str());
  };
  within("camera width", width, 1, kMaxSize);
  within("camera height", height, 1, kMaxSize);
  within("camera fx", fx, kMinFocal, kMaxFocal);
  within("camera fy", fy, kMinFocal, kMaxFocal);
  within("camera cx", cx, -kMaxFocal, kMaxFocal);
  within("camera cy", cy, -kMaxFocal, kMaxFocal);
  if (coefficients.size() > coefficientCount(model)) {
    throwBadValue("number of distortion coefficients", coefficients.size(),
                  "the lens model has " + std::to_string(coefficientCount(model)));
  }
  for (const double k : coefficients) {
    if (!std::isfinite(k)) throwBadValue("distortion coefficient", k, "it must be finite");
  }
}

namespace {

/// Factor by which the images of a calibration were larger than these, as far as its principal point tells. In another
/// size both of its coordinates lie off the middle by the same factor, farther than those of real cameras (some 8 % of
/// the size). None if they do not.
std::optional<double> factorOfSize(const CameraModel& camera) {
  constexpr double kLeastFactor = 1.17;
  constexpr double kAgreement = 1.15;
  const double x = 2.0 * camera.cx / camera.width;
  const double y = 2.0 * camera.cy / camera.height;
  if (!(x > 0.0 && y > 0.0) || std::max(x, y) > kAgreement * std::min(x, y)) return std::nullopt;
  const bool larger = std::min(x, y) >= kLeastFactor;
  const bool smaller = std::max(x, y) <= 1.0 / kLeastFactor;
  if (!larger && !smaller) return std::nullopt;
  return std::sqrt(x * y);
}

}  // namespace

std::optional<std::string> CameraModel::doubt() const {
  constexpr double kFarFromMiddle = 0.2;  // share of the size
  std::ostringstream text;
  const std::optional<double> factor = factorOfSize(*this);
  if (!factor && std::abs(cx / width - 0.5) <= kFarFromMiddle &&
      std::abs(cy / height - 0.5) <= kFarFromMiddle) {
    const auto bent = pixelBentTooFar(*this);
    if (!bent) return std::nullopt;
    text << "the distortion coefficients leave nothing of the picture at pixel (" << bent->x() << ", "
         << bent->y() << "), half-way to a corner: are they this camera's, and in the order of the model?";
    return text.str();
  }
  text << "the principal point (" << cx << ", " << cy << ") lies far from the middle of images of " << width
       << "x" << height << " px: is the calibration that of images of another size";
  if (factor) {
    text << ", of about " << std::lround(*factor * width) << "x" << std::lround(*factor * height);
  }
  text << "?";
  return text.str();
}

CameraModel makeCamera(CameraModel pinhole, const std::string& lens_name, std::vector<double> coefficients) {
  pinhole.model = LensModel::kNone;
  pinhole.coefficients.clear();
  const bool bends = std::any_of(coefficients.begin(), coefficients.end(), [](double k) { return k != 0.0; });
  if (bends) {
    pinhole.model = lensModelFromName(lens_name);
    const std::size_t count = coefficientCount(pinhole.model);
    while (coefficients.size() > count && coefficients.back() == 0.0) coefficients.pop_back();
    pinhole.coefficients = std::move(coefficients);
  }
  pinhole.validate();
  return pinhole;
}

void requireNoSkew(const std::string& name, double skew, const CameraModel& camera) {
  constexpr double kVisible = 0.5;  // [px]
  const double farthest = std::max(std::abs(camera.cy), std::abs(camera.height - camera.cy)) / camera.fy;
  if (!(std::abs(skew) * farthest < kVisible)) throwBadValue(name + " (skew)", skew, "it must be 0");
}

Eigen::Vector2d CameraModel::undistort(const Eigen::Vector2d& raw) const {
  if (model == LensModel::kNone) return raw;
  const Eigen::Vector2d start = firstGuess(*this, {(raw.x() - cx) / fx, (raw.y() - cy) / fy});
  return undistort(raw, {fx * start.x() + cx, fy * start.y() + cy});
}

Eigen::Vector2d CameraModel::undistort(const Eigen::Vector2d& raw, const Eigen::Vector2d& guess) const {
  if (model == LensModel::kNone) return raw;
  const Eigen::Vector2d bent((raw.x() - cx) / fx, (raw.y() - cy) / fy);
  const Coefficients k = coefficientsOf(*this);
  Eigen::Vector2d ideal((guess.x() - cx) / fx, (guess.y() - cy) / fy);
  for (int step = 0; step < kMaxNewtonSteps; ++step) {
    const BentBearing now = bend(model, k, ideal);
    const Eigen::Vector2d error = now.bearing - bent;
    const double determinant = now.jacobian.determinant();
    if (!(std::abs(determinant) > 1e-9)) break;
    const Eigen::Vector2d correction =
        Eigen::Vector2d(now.jacobian(1, 1) * error.x() - now.jacobian(0, 1) * error.y(),
                        now.jacobian(0, 0) * error.y() - now.jacobian(1, 0) * error.x()) /
        determinant;
    ideal -= correction;
    // Newton's method squares the error: after this step it is far below a thousandth of a pixel.
    if (!(correction.squaredNorm() > kNewtonTolerance)) break;
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
  const Eigen::Vector2d bent =
      bend(model, coefficientsOf(*this), {(pixel.x() - cx) / fx, (pixel.y() - cy) / fy}).bearing;
  return {fx * bent.x() + cx, fy * bent.y() + cy};
}

DistortedPixel CameraModel::distortWithJacobian(const Eigen::Vector2d& pixel) const {
  if (model == LensModel::kNone) return {pixel, Eigen::Matrix2d::Identity()};
  BentBearing bent = bend(model, coefficientsOf(*this), {(pixel.x() - cx) / fx, (pixel.y() - cy) / fy});
  bent.jacobian(0, 1) *= fx / fy;
  bent.jacobian(1, 0) *= fy / fx;
  return {{fx * bent.bearing.x() + cx, fy * bent.bearing.y() + cy}, bent.jacobian};
}

CameraModel CameraModel::withLensChange(const LensChange& change) const {
  CameraModel changed = *this;
  if (changed.model == LensModel::kNone) changed.model = LensModel::kPlumbBob;
  const std::size_t count = changed.model == LensModel::kEquidistant ? 2 : 4;
  if (changed.coefficients.size() < count) changed.coefficients.resize(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) changed.coefficients[i] += change(static_cast<Eigen::Index>(i));
  return changed;
}

}  // namespace ratslam
