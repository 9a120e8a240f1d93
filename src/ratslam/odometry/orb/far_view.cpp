#include "ratslam/odometry/orb/far_view.h"

#include "ratslam/common/angles.h"
#include "ratslam/vision/bundle_adjustment.h"
#include "ratslam/vision/matching.h"
#include "ratslam/vision/two_view.h"

namespace ratslam {
namespace {

constexpr int kMostDistance = 50;  // [bits]
constexpr int kClearly = 8;        // bits by which the best must beat the second best
constexpr TwoViewParams kTwoView{30, 0.3, 1.5};
constexpr double kPixelSigma = 1.0;         // of features that are matched, not aligned [px]
constexpr double kRotationSigmaDeg = 0.25;  // what such matches leave
constexpr double kDirectionSigmaDeg = 1.5;
constexpr int kRounds = 15;

/// For each feature of `from` the one most like it in `to`, or -1.
std::vector<int> mostSimilar(const Frame& from, const Frame& to) {
  std::vector<int> best(from.features.size(), -1);
  for (std::size_t i = 0; i < from.features.size(); ++i) {
    int least = kMostDistance + 1;
    int second = 256;
    for (int k = 0; k < static_cast<int>(to.features.size()); ++k) {
      const int distance = hammingDistance(from.descriptor(static_cast<int>(i)), to.descriptor(k));
      if (distance < least) {
        second = least;
        least = distance;
        best[i] = k;
      } else if (distance < second) {
        second = distance;
      }
    }
    if (least + kClearly > second) best[i] = -1;
  }
  return best;
}

/// Rotation, direction and points together; the length of the way drifts freely and is taken out afterwards.
RigidTransform refined(const CameraModel& camera, const TwoViewMotion& motion,
                       const std::vector<Eigen::Vector2d>& before,
                       const std::vector<Eigen::Vector2d>& after) {
  BundleProblem problem;
  problem.poses = {motion.T_second_first, RigidTransform{}};
  problem.free_poses = 1;
  for (std::size_t i = 0; i < motion.points.size(); ++i) {
    if (!motion.points[i]) continue;
    const int point = static_cast<int>(problem.points.size());
    problem.points.push_back(*motion.points[i]);
    problem.observations.push_back({0, point, after[i], kPixelSigma});
    problem.observations.push_back({1, point, before[i], kPixelSigma});
  }
  BundleOptions options;
  options.max_iterations = kRounds;
  adjustBundle(camera, problem, options);
  RigidTransform result = problem.poses.front();
  result.translation.normalize();
  return result.translation.allFinite() ? result : motion.T_second_first;
}

}  // namespace

std::optional<FarView> compareFarFeatures(const CameraModel& camera, const Frame& before,
                                          const Frame& after) {
  const std::vector<int> forth = mostSimilar(before, after);
  const std::vector<int> back = mostSimilar(after, before);
  std::vector<Eigen::Vector2d> first;
  std::vector<Eigen::Vector2d> second;
  for (std::size_t i = 0; i < forth.size(); ++i) {
    if (forth[i] < 0 || back[static_cast<std::size_t>(forth[i])] != static_cast<int>(i)) continue;
    first.push_back(before.features[i].pixel);
    second.push_back(after.features[static_cast<std::size_t>(forth[i])].pixel);
  }
  const auto motion = estimateTwoViewMotion(camera, first, second, kTwoView);
  if (!motion) return std::nullopt;
  FarView view;
  view.T_after_before = refined(camera, *motion, first, second);
  view.rotation_sigma = degreesToRadians(kRotationSigmaDeg);
  view.direction_sigma = degreesToRadians(kDirectionSigmaDeg);
  view.points = motion->triangulated;
  return view;
}

}  // namespace ratslam
