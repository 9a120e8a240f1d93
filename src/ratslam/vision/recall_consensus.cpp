#include "ratslam/vision/recall_consensus.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "ratslam/vision/essential_matrix.h"

namespace ratslam {
namespace {

constexpr ConsensusParams kEpipolar{0.99, 50, 150};
constexpr ConsensusParams kResection{0.99, 50, 300};

ConsensusScore poseScore(const RecallView& view, const std::vector<RecallPair>& pairs) {
  ConsensusScore score{0.0, 0};
  for (const RecallPair& pair : pairs) {
    const double error = recallError(
        view, pair, pair.inverse_depth ? *pair.inverse_depth : inverseDepth(view, pair.anchor, pair.bearing));
    score.add(error * error);
  }
  return score;
}

/// Of the four motions of an essential matrix, the one with most points in front of both views.
RecallView motionOf(const Eigen::Matrix3d& essential, const std::vector<RecallPair>& pairs) {
  RecallView best;
  ConsensusScore best_score;
  for (const RigidTransform& motion : decomposeEssential(essential)) {
    const RecallView view{motion.rotation.toRotationMatrix(), motion.translation, RecallMotion::kUnit};
    const ConsensusScore score = poseScore(view, pairs);
    if (score.cost < best_score.cost) {
      best = view;
      best_score = score;
    }
  }
  return best;
}

}  // namespace

double recallError(const RecallView& view, const RecallPair& pair, double inverse_depth) {
  const Eigen::Vector3d m = view.R * pair.anchor.homogeneous() + inverse_depth * view.t;
  if (!(m.z() > 0.0)) return std::numeric_limits<double>::infinity();
  return (m.hnormalized() - pair.bearing).norm() / pair.sigma;
}

std::optional<RecallView> epipolarConsensus(const std::vector<RecallPair>& pairs, int min_inliers) {
  std::vector<BearingPair> bearings;
  bearings.reserve(pairs.size());
  for (const RecallPair& pair : pairs) bearings.push_back({pair.anchor, pair.bearing, pair.sigma});
  const std::optional<Eigen::Matrix3d> essential = essentialConsensus(bearings, min_inliers, kEpipolar);
  if (!essential) return std::nullopt;
  return motionOf(*essential, pairs);
}

std::optional<RecallView> resectionConsensus(const std::vector<RecallPair>& pairs, int min_inliers) {
  constexpr std::size_t kSize = 3;
  std::vector<RecallPair> known;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(known),
               [](const RecallPair& pair) { return pair.inverse_depth && *pair.inverse_depth > 0.0; });
  if (known.size() < std::max<std::size_t>(kSize + 1, static_cast<std::size_t>(min_inliers)))
    return std::nullopt;
  RecallView best;
  ConsensusScore best_score;
  drawSamples<kSize>(known.size(), kResection, [&](const std::array<std::size_t, kSize>& sample) {
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> bearings;
    for (const std::size_t i : sample) {
      const RecallPair& pair = known[i];
      points.emplace_back(pair.anchor.x() / *pair.inverse_depth, pair.anchor.y() / *pair.inverse_depth,
                          1.0 / *pair.inverse_depth);
      bearings.emplace_back(pair.bearing.x(), pair.bearing.y());
    }
    std::vector<cv::Mat> turns;
    std::vector<cv::Mat> translations;
    cv::solveP3P(points, bearings, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turns, translations,
                 cv::SOLVEPNP_AP3P);
    for (std::size_t s = 0; s < turns.size(); ++s) {
      Eigen::Vector3d turn;
      RecallView view;
      cv::cv2eigen(turns[s], turn);
      cv::cv2eigen(translations[s], view.t);
      if (!turn.allFinite() || !view.t.allFinite()) continue;
      view.R = Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()).toRotationMatrix();
      const ConsensusScore score = poseScore(view, known);
      if (score.cost < best_score.cost) {
        best = view;
        best_score = score;
      }
    }
    return best_score.inliers;
  });
  if (best_score.inliers < min_inliers) return std::nullopt;
  return best;
}

}  // namespace ratslam
