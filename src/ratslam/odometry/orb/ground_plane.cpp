#include "ratslam/odometry/orb/ground_plane.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/common/statistics.h"

namespace ratslam {
namespace {

struct Stage {
  int level;         // of the pyramid
  int most_samples;  // approximate
};
constexpr std::array<Stage, 3> kStages = {{{5, 300}, {3, 300}, {1, 700}}};  // coarse to fine
constexpr int kSteps = 4;                                                   // per level
constexpr std::size_t kLeastSamples = 150;
constexpr int kCandidates = 40;        // heights tried by the search
constexpr double kMostBend = 0.3;      // [1/camera height], of a car's smallest circle
constexpr double kMostTurn = 0.8;      // of the lane within the patch [rad]: beyond it a parabola is no arc
constexpr double kMinGreySigma = 1.5;  // least standard deviation of the noise [grey levels]
// Number of samples that count as one independent measurement, because neighbours share noise and texture.
constexpr double kCorrelatedSamples = 10.0;

float bilinear(const cv::Mat& image, double x, double y) {
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const auto fx = static_cast<float>(x - column);
  const auto fy = static_cast<float>(y - row);
  const uchar* upper = image.ptr<uchar>(row) + column;
  const uchar* lower = image.ptr<uchar>(row + 1) + column;
  return (1.0F - fy) * ((1.0F - fx) * upper[0] + fx * upper[1]) +
         fy * ((1.0F - fx) * lower[0] + fx * lower[1]);
}

/// Central differences of the bilinear grey value.
Eigen::Vector2d slope(const cv::Mat& image, double x, double y) {
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const double fx = x - column;
  const double fy = y - row;
  const auto at = [&](int v, int u) -> double { return image.ptr<uchar>(row + v)[column + u]; };
  const double above = (1.0 - fx) * (at(0, 1) - at(0, -1)) + fx * (at(0, 2) - at(0, 0));
  const double below = (1.0 - fx) * (at(1, 1) - at(1, -1)) + fx * (at(1, 2) - at(1, 0));
  const double left = (1.0 - fy) * (at(1, 0) - at(-1, 0)) + fy * (at(2, 0) - at(0, 0));
  const double right = (1.0 - fy) * (at(1, 1) - at(-1, 1)) + fy * (at(2, 1) - at(0, 1));
  return 0.5 * Eigen::Vector2d((1.0 - fy) * above + fy * below, (1.0 - fx) * left + fx * right);
}

bool inside(const cv::Mat& image, const Eigen::Vector2d& p) {
  return p.x() >= 1.0 && p.y() >= 1.0 && p.x() < image.cols - 2.0 && p.y() < image.rows - 2.0;
}

struct RoadSample {
  Eigen::Vector3d bearing;
  double grey = 0.0;
};

/// Grey values of the present lane, on a regular grid of one pyramid level.
/// @param bend curvature of the lane [1/camera height], positive to the right
std::vector<RoadSample> sampleRoad(const CameraModel& camera, const Frame& now, const RoadPlane& plane,
                                   double bend, const Stage& stage, const RoadParams& params) {
  // The predicted plane gives the range of rows, the lane's width the columns.
  const double horizon = camera.cy - camera.fy * plane.normal.z() / plane.normal.y();
  const double top = std::max(0.0, horizon + camera.fy / params.farthest);
  const double bottom = std::min(camera.height - 1.0, horizon + camera.fy / params.nearest);
  const double slope =
      camera.fx / camera.fy * params.half_width;  // half the lane's width / rows below the horizon [px]
  const double area = slope * ((bottom - horizon) * (bottom - horizon) - (top - horizon) * (top - horizon));
  std::vector<RoadSample> samples;
  if (!(bottom - top > 8.0) || !(area > 0.0)) return samples;
  const cv::Mat& image = now.pyramid.image(stage.level);
  const double spacing = std::max(now.pyramid.scale(stage.level), std::sqrt(area / stage.most_samples));
  for (double v = top; v <= bottom; v += spacing) {
    const double reach = slope * (v - horizon);
    const double ahead = camera.fy / (v - horizon);  // [camera heights]
    if (std::abs(bend) * ahead > kMostTurn) continue;
    const double middle = camera.cx + 0.5 * camera.fx * bend * ahead;
    for (double u = middle - reach; u <= middle + reach; u += spacing) {
      const Eigen::Vector2d at = now.pyramid.toLevel(camera.distort({u, v}), stage.level);
      const Eigen::Vector3d bearing = camera.bearing({u, v});
      if (!inside(image, at) || !(plane.normal.dot(bearing) > 0.0)) continue;
      samples.push_back({bearing, bilinear(image, at.x(), at.y())});
    }
  }
  return samples;
}

/// Grey values of the samples in an earlier view through the plane m.X = 1, and their derivatives by m.
struct Warped {
  std::vector<std::size_t> sample;  // those inside the image
  std::vector<double> grey;
  std::vector<Eigen::Vector3d> gradient;
};

Warped warpSamples(const CameraModel& camera, const std::vector<RoadSample>& samples, const Frame& earlier,
                   const RigidTransform& T_earlier_now, const Eigen::Vector3d& m, int level,
                   bool with_gradient) {
  Warped warped;
  warped.sample.reserve(samples.size());
  warped.grey.reserve(samples.size());
  if (with_gradient) warped.gradient.reserve(samples.size());
  const cv::Mat& image = earlier.pyramid.image(level);
  const Eigen::Matrix3d rotation = T_earlier_now.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = T_earlier_now.translation;
  const double scale = earlier.pyramid.scale(level);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d& b = samples[i].bearing;
    const Eigen::Vector3d x = rotation * b + t * m.dot(b);
    if (!(x.z() > 0.05)) continue;
    const DistortedPixel seen = camera.distortWithJacobian(camera.project(x));
    const Eigen::Vector2d at = earlier.pyramid.toLevel(seen.raw, level);
    if (!inside(image, at)) continue;
    warped.sample.push_back(i);
    warped.grey.push_back(bilinear(image, at.x(), at.y()));
    if (!with_gradient) continue;
    const Eigen::Vector2d motion(camera.fx * (t.x() - x.x() / x.z() * t.z()) / x.z(),
                                 camera.fy * (t.y() - x.y() / x.z() * t.z()) / x.z());
    const double along = slope(image, at.x(), at.y()).dot(seen.jacobian * motion) / scale;
    warped.gradient.push_back(along * b);
  }
  return warped;
}

/// Mean of some values.
double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

struct Comparison {
  std::vector<double> residual;  // warped - gain * sample, each without its mean
  double correlation = 0.0;
};

Comparison compare(const std::vector<RoadSample>& samples, const Warped& warped) {
  Comparison result;
  std::vector<double> here;
  here.reserve(warped.sample.size());
  for (const std::size_t i : warped.sample) here.push_back(samples[i].grey);
  const double mean_here = mean(here);
  const double mean_there = mean(warped.grey);
  double hh = 0.0;
  double ht = 0.0;
  double tt = 0.0;
  for (std::size_t i = 0; i < here.size(); ++i) {
    const double h = here[i] - mean_here;
    const double t = warped.grey[i] - mean_there;
    hh += h * h;
    ht += h * t;
    tt += t * t;
  }
  if (!(hh > 0.0) || !(tt > 0.0)) return result;
  result.correlation = ht / std::sqrt(hh * tt);
  const double gain = std::max(0.1, ht / hh);
  for (std::size_t i = 0; i < here.size(); ++i) {
    result.residual.push_back(warped.grey[i] - mean_there - gain * (here[i] - mean_here));
  }
  return result;
}

/// The plane after small changes (log height, tilt about x, tilt about z).
RoadPlane moved(const RoadPlane& plane, const Eigen::Vector3d& change) {
  const Eigen::Vector3d normal = expRotation({change(1), 0.0, change(2)}) * plane.normal;
  return {normal.normalized(), plane.height * std::exp(change(0))};
}

/// Derivative of m = n/h by those changes.
Eigen::Matrix3d planeJacobian(const RoadPlane& plane) {
  Eigen::Matrix3d jacobian;
  jacobian.col(0) = -plane.normal;
  jacobian.col(1) = Eigen::Vector3d::UnitX().cross(plane.normal);
  jacobian.col(2) = Eigen::Vector3d::UnitZ().cross(plane.normal);
  return jacobian / plane.height;
}

/// How far the plane's normal is turned from another's (about x, about z) [rad].
Eigen::Vector2d tiltBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d axis = from.cross(to);
  return {axis.x(), axis.z()};
}

/// Curvature of the way to here [1/camera height], positive to the right.
double bendOf(const Frame& now, const Frame& earlier, double height) {
  const RigidTransform way = earlier.T_camera_world * now.T_camera_world.inverse();
  const double length = way.translation.norm();
  if (!(std::abs(way.translation.z()) > 0.5 * length)) return 0.0;  // the camera looks to the side
  const double ahead = way.translation.z() < 0.0 ? -1.0 : 1.0;
  return ahead * std::clamp(logRotation(way.rotation).y() / length * height, -kMostBend, kMostBend);
}

struct Fit {
  RoadPlane plane;
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d centre =
      Eigen::Vector3d::Zero();  // mean of the samples, weighted by what they tell about the height
  double information = 0.0;     // about the log height, from the samples alone
  double correlation = -1.0;
};

/// Gauss-Newton on one level. @return false if too little of the road is visible.
bool fitLevel(const CameraModel& camera, const Frame& now, const std::vector<const Frame*>& earlier,
              const RoadPlane& prior, double bend, const Stage& stage, const RoadParams& params, Fit& fit) {
  const std::vector<RoadSample> samples = sampleRoad(camera, now, fit.plane, bend, stage, params);
  if (samples.size() < kLeastSamples) return false;
  const double tilt_information = 1.0 / std::pow(degreesToRadians(params.tilt_sigma_deg), 2);
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Matrix3d by_change = planeJacobian(fit.plane);
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    double correlation = 0.0;
    fit.centre.setZero();
    fit.information = 0.0;
    for (const Frame* frame : earlier) {
      const RigidTransform T = frame->T_camera_world * now.T_camera_world.inverse();
      const Warped warped =
          warpSamples(camera, samples, *frame, T, fit.plane.normal / fit.plane.height, stage.level, true);
      if (warped.sample.size() < kLeastSamples) return false;
      const Comparison comparison = compare(samples, warped);
      if (comparison.residual.empty()) return false;
      correlation += comparison.correlation / static_cast<double>(earlier.size());
      const double sigma = std::max(kMinGreySigma, 1.4826 * medianDeviation(comparison.residual, 0.0));
      for (std::size_t i = 0; i < comparison.residual.size(); ++i) {
        const double normalised = comparison.residual[i] / sigma;
        const double weight =
            1.0 / ((1.0 + normalised * normalised) * sigma * sigma * kCorrelatedSamples);  // Cauchy
        const Eigen::Vector3d jacobian = by_change.transpose() * warped.gradient[i];
        const double information = weight * jacobian(0) * jacobian(0);
        const Eigen::Vector3d& bearing = samples[warped.sample[i]].bearing;
        const double facing = fit.plane.normal.dot(bearing);
        if (facing > 0.0) {
          fit.centre += information * fit.plane.height / facing * bearing;
          fit.information += information;
        }
        hessian += weight * jacobian * jacobian.transpose();
        gradient += weight * comparison.residual[i] * jacobian;
      }
    }
    const Eigen::Vector2d tilt = tiltBetween(prior.normal, fit.plane.normal);
    hessian(1, 1) += tilt_information;
    hessian(2, 2) += tilt_information;
    gradient.tail<2>() += tilt_information * tilt;
    Eigen::Vector3d change = -hessian.ldlt().solve(gradient);
    if (!change.allFinite()) return false;
    change(0) = std::clamp(change(0), -0.3, 0.3);
    fit.plane = moved(fit.plane, change);
    fit.hessian = hessian;
    fit.correlation = correlation;
    if (change.squaredNorm() < 1e-8) break;
  }
  return true;
}

}  // namespace

std::optional<RoadMeasurement> measureRoad(const CameraModel& camera, const Frame& now,
                                           const std::vector<const Frame*>& earlier,
                                           const RoadPlane& predicted, const RoadParams& params) {
  if (earlier.empty() || !(predicted.height > 0.0) || !(predicted.normal.y() > 0.5)) return std::nullopt;
  Fit fit;
  fit.plane = predicted;
  const double bend = bendOf(now, *earlier.back(), predicted.height);
  for (const Stage& stage : kStages) {
    if (stage.level >= now.pyramid.levels()) continue;
    if (!fitLevel(camera, now, earlier, predicted, bend, stage, params, fit)) return std::nullopt;
    if (!(fit.plane.normal.y() > 0.5) || !std::isfinite(fit.plane.height)) return std::nullopt;
  }
  if (fit.correlation < params.min_correlation) return std::nullopt;
  // Without motion towards the road the height is unobservable, and the inverse below would be meaningless.
  if (!(fit.hessian(0, 0) * params.max_sigma_log * params.max_sigma_log > 1.0)) return std::nullopt;
  RoadMeasurement measurement;
  measurement.plane = fit.plane;
  measurement.correlation = fit.correlation;
  measurement.sigma_log =
      std::sqrt(Eigen::Matrix3d(fit.hessian.ldlt().solve(Eigen::Matrix3d::Identity()))(0, 0));
  if (!(measurement.sigma_log <= params.max_sigma_log)) return std::nullopt;
  measurement.centre = fit.centre / fit.information;
  measurement.sigma_centre = 1.0 / std::sqrt(fit.information);
  return measurement;
}

std::optional<RoadMeasurement> searchRoad(const CameraModel& camera, const Frame& now,
                                          const std::vector<const Frame*>& earlier,
                                          const Eigen::Vector3d& normal, double lowest, double highest,
                                          const RoadParams& params) {
  if (earlier.empty() || !(lowest > 0.0) || !(highest > lowest)) return std::nullopt;
  const Stage stage{std::min(kStages.front().level, now.pyramid.levels() - 1), kStages.front().most_samples};
  double best_height = 0.0;
  double best_correlation = -1.0;
  // The patch of road is stated in camera heights, so its image is the same for all heights.
  const std::vector<RoadSample> samples = sampleRoad(camera, now, {normal, 1.0}, 0.0, stage, params);
  if (samples.size() < kLeastSamples) return std::nullopt;
  for (int candidate = 0; candidate < kCandidates; ++candidate) {
    const double height = lowest * std::pow(highest / lowest, candidate / (kCandidates - 1.0));
    double correlation = 0.0;
    for (const Frame* frame : earlier) {
      const RigidTransform T = frame->T_camera_world * now.T_camera_world.inverse();
      const Warped warped = warpSamples(camera, samples, *frame, T, normal / height, stage.level, false);
      if (2 * warped.sample.size() < samples.size()) continue;
      correlation += compare(samples, warped).correlation / static_cast<double>(earlier.size());
    }
    if (correlation > best_correlation) {
      best_correlation = correlation;
      best_height = height;
    }
  }
  if (best_height == 0.0) return std::nullopt;
  return measureRoad(camera, now, earlier, {normal, best_height}, params);
}

}  // namespace ratslam
