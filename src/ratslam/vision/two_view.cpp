#include "ratslam/vision/two_view.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "ratslam/common/angles.h"
#include "ratslam/common/statistics.h"
#include "ratslam/vision/essential_matrix.h"
#include "ratslam/vision/pose_refinement.h"
#include "ratslam/vision/triangulation.h"

namespace ratslam {
namespace {

constexpr std::size_t kMinMatches = 16;
constexpr ConsensusParams kEssential{0.9999, 50, 1000};
constexpr double kHomographyShare = 0.5;  // of the sum of both scores; above it the scene counts as flat
constexpr double kClearlyBest = 0.75;     // bound on points of the second best solution / points of the best

std::vector<cv::Point2d> toPoints(const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<cv::Point2d> points;
  points.reserve(pixels.size());
  for (const auto& p : pixels) points.emplace_back(p.x(), p.y());
  return points;
}

/// Squared distance of b from the image of a by the homography.
double transferError(const Eigen::Matrix3d& homography, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return ((homography * a.homogeneous()).hnormalized() - b).squaredNorm();
}

/// Squared distance of b from the epipolar line of a.
double epipolarError(const Eigen::Matrix3d& fundamental, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector3d line = fundamental * a.homogeneous();
  const double distance = line.dot(b.homogeneous());
  return distance * distance / line.head<2>().squaredNorm();
}

/// Sum over all matches and both images of `limit` - error, where the error is below `bound`. Chi-square bounds of
/// two and one degrees of freedom make the two models comparable.
template <class Error>
double score(std::size_t matches, double bound, double limit, const Error& error) {
  double sum = 0.0;
  for (std::size_t i = 0; i < matches; ++i) {
    for (const double e : {error(i, true), error(i, false)}) {
      if (e < bound) sum += limit - e;
    }
  }
  return sum;
}

/// The essential matrix whose distances are below `max_error` [px] for most matches; none if too few agree.
std::optional<Eigen::Matrix3d> fitEssential(const CameraModel& camera,
                                            const std::vector<Eigen::Vector2d>& first,
                                            const std::vector<Eigen::Vector2d>& second, double max_error) {
  const Eigen::Matrix3d k = camera.matrix();
  // Sampson's distance, which spans both images, is half of what a pair's sigma expects. At the gate it is max_error.
  const double sigma = std::sqrt(2.0) * max_error / (0.5 * (k(0, 0) + k(1, 1))) / ConsensusScore::kGate;
  std::vector<BearingPair> pairs;
  pairs.reserve(first.size());
  for (std::size_t i = 0; i < first.size(); ++i)
    pairs.push_back({camera.bearing(first[i]).hnormalized(), camera.bearing(second[i]).hnormalized(), sigma});
  return essentialConsensus(pairs, 0, kEssential);
}

std::vector<RigidTransform> decomposeHomography(const CameraModel& camera,
                                                const Eigen::Matrix3d& homography) {
  cv::Mat h;
  cv::Mat k;
  cv::eigen2cv(homography, h);
  const Eigen::Matrix3d camera_matrix = camera.matrix();
  cv::eigen2cv(camera_matrix, k);
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  std::vector<cv::Mat> normals;
  cv::decomposeHomographyMat(h, k, rotations, translations, normals);
  std::vector<RigidTransform> motions;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    Eigen::Matrix3d r;
    Eigen::Vector3d t;
    cv::cv2eigen(rotations[i], r);
    cv::cv2eigen(translations[i], t);
    if (t.norm() > 1e-9) motions.push_back({Eigen::Quaterniond(r).normalized(), t.normalized()});
  }
  return motions;
}

TwoViewMotion triangulateAll(const CameraModel& camera, const RigidTransform& motion,
                             const std::vector<Eigen::Vector2d>& first,
                             const std::vector<Eigen::Vector2d>& second, double max_error) {
  TwoViewMotion result;
  result.T_second_first = motion;
  result.points.resize(first.size());
  std::vector<double> angles;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const std::vector<View> views = {{RigidTransform{}, first[i], 1.0}, {motion, second[i], 1.0}};
    const auto point = triangulate(camera, views);
    if (!point) continue;
    const bool fits = std::all_of(views.begin(), views.end(), [&](const View& view) {
      const Reprojection reprojection = reproject(camera, view.T_camera_world * *point, view.pixel);
      return reprojection.error.norm() <= 2.0 * max_error;
    });
    if (!fits) continue;
    result.points[i] = *point;
    angles.push_back(radiansToDegrees(parallax(*point, views)));
  }
  result.triangulated = static_cast<int>(angles.size());
  if (!angles.empty()) result.parallax_deg = median(std::move(angles));
  return result;
}

}  // namespace

std::optional<TwoViewMotion> estimateTwoViewMotion(const CameraModel& camera,
                                                   const std::vector<Eigen::Vector2d>& first,
                                                   const std::vector<Eigen::Vector2d>& second,
                                                   const TwoViewParams& params) {
  if (first.size() < std::max(kMinMatches, static_cast<std::size_t>(params.min_points))) return std::nullopt;
  const std::vector<cv::Point2d> a = toPoints(first);
  const std::vector<cv::Point2d> b = toPoints(second);
  // Both estimators have their own random generators with a fixed seed.
  const cv::Mat h = cv::findHomography(a, b, cv::RANSAC, 2.0 * params.max_error);
  const std::optional<Eigen::Matrix3d> essential = fitEssential(camera, first, second, params.max_error);

  constexpr double kTwoFreedoms = 5.991;  // 95 % bounds of the chi-square distribution
  constexpr double kOneFreedom = 3.841;
  const double unit = params.max_error * params.max_error;
  double homography_score = 0.0;
  double essential_score = 0.0;
  Eigen::Matrix3d homography = Eigen::Matrix3d::Identity();
  if (h.rows == 3) {
    cv::cv2eigen(h, homography);
    const Eigen::Matrix3d back = homography.inverse();
    homography_score =
        score(first.size(), kTwoFreedoms * unit, kTwoFreedoms * unit, [&](std::size_t i, bool forth) {
          return forth ? transferError(homography, first[i], second[i])
                       : transferError(back, second[i], first[i]);
        });
  }
  if (essential) {
    const Eigen::Matrix3d inverse = camera.matrix().inverse();
    const Eigen::Matrix3d f = inverse.transpose() * *essential * inverse;
    essential_score =
        score(first.size(), kOneFreedom * unit, kTwoFreedoms * unit, [&](std::size_t i, bool forth) {
          return forth ? epipolarError(f, first[i], second[i])
                       : epipolarError(f.transpose(), second[i], first[i]);
        });
  }
  const double total = homography_score + essential_score;
  if (!(total > 0.0)) return std::nullopt;

  const bool flat = homography_score > kHomographyShare * total;
  const auto motions = flat ? decomposeHomography(camera, homography) : decomposeEssential(*essential);
  std::optional<TwoViewMotion> best;
  int runner_up = 0;
  for (const RigidTransform& motion : motions) {
    TwoViewMotion candidate = triangulateAll(camera, motion, first, second, params.max_error);
    if (!best || candidate.triangulated > best->triangulated) {
      if (best) runner_up = best->triangulated;
      best = std::move(candidate);
    } else {
      runner_up = std::max(runner_up, candidate.triangulated);
    }
  }
  if (!best || best->triangulated < params.min_points || runner_up > kClearlyBest * best->triangulated ||
      best->parallax_deg < params.min_parallax_deg) {
    return std::nullopt;
  }
  return best;
}

}  // namespace ratslam
