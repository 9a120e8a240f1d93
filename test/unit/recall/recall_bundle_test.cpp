#include "ratslam/vision/recall_bundle.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "ratslam/vision/recall_consensus.h"

namespace ratslam {
namespace {

constexpr double kSigma = 1e-3;

/// Deterministic noise of unit variance, near enough to Gaussian.
double noise(std::mt19937& generator) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(generator()) / 4294967296.0;
  return sum;
}

RecallView viewAt(const Eigen::Vector3d& centre, double turn, RecallMotion motion) {
  RecallView view;
  view.R = Eigen::AngleAxisd(turn, Eigen::Vector3d(0.1, 1.0, -0.05).normalized()).toRotationMatrix();
  view.t = -view.R * centre;
  view.motion = motion;
  return view;
}

const RecallView kPresent = viewAt({0.6, -0.1, 0.8}, 0.15, RecallMotion::kFree);
const RecallView kCompanion = viewAt({0.0, 0.0, -1.0}, -0.02, RecallMotion::kUnit);

/// Points seen in the anchor, exactly, and in two views with noise of `share` sigmas.
RecallBundle scene(unsigned seed, double share) {
  std::mt19937 generator(seed);
  const auto uniform = [&generator](double low, double high) {
    return low + (high - low) * static_cast<double>(generator()) / 4294967296.0;
  };
  RecallBundle bundle;
  bundle.views = {kPresent, kCompanion};
  for (int i = 0; i < 120; ++i) {
    RecallPoint point{{uniform(-0.8, 0.8), uniform(-0.25, 0.25)}, 1.0 / uniform(4.0, 40.0), 0.0};
    for (int v = 0; v < 2; ++v) {
      const RecallView& view = bundle.views[static_cast<std::size_t>(v)];
      const Eigen::Vector3d m = view.R * point.bearing.homogeneous() + point.inverse_depth * view.t;
      const Eigen::Vector2d error(noise(generator), noise(generator));
      bundle.observations.push_back({v, i, m.hnormalized() + share * kSigma * error, kSigma, true});
    }
    bundle.points.push_back(point);
  }
  return bundle;
}

/// A start some way off the truth.
void disturb(RecallBundle& bundle) {
  bundle.views[0] = viewAt({0.5, 0.0, 0.9}, 0.16, RecallMotion::kFree);
  bundle.views[1].t = (bundle.views[1].t + Eigen::Vector3d(0.03, -0.02, 0.0)).normalized();
  for (RecallPoint& point : bundle.points) point.inverse_depth *= 1.2;
}

std::vector<RecallPair> pairsOf(const RecallBundle& bundle, int view, bool with_depth) {
  std::vector<RecallPair> pairs;
  for (const RecallObservation& seen : bundle.observations) {
    if (seen.view != view) continue;
    const RecallPoint& point = bundle.points[static_cast<std::size_t>(seen.point)];
    pairs.push_back({point.bearing, seen.bearing, seen.sigma, std::nullopt});
    if (with_depth) pairs.back().inverse_depth = point.inverse_depth;
  }
  return pairs;
}

TEST(RecallBundle, RestoresAnExactScene) {
  RecallBundle bundle = scene(1, 0.0);
  disturb(bundle);
  ASSERT_TRUE(refineRecallBundle(bundle).has_value());
  EXPECT_EQ(inlierCount(bundle, 0), 120);
  EXPECT_NEAR((bundle.views[0].R - kPresent.R).norm(), 0.0, 1e-6);
  EXPECT_NEAR((bundle.views[0].t - kPresent.t).norm(), 0.0, 1e-6);
  EXPECT_NEAR((bundle.views[1].t - kCompanion.t).norm(), 0.0, 1e-6);
  EXPECT_NEAR(bundle.views[1].t.norm(), 1.0, 1e-12);
}

TEST(RecallBundle, CovarianceIsThatOfTheErrors) {
  constexpr int kTrials = 60;
  double sum = 0.0;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    RecallBundle bundle = scene(seed, 0.7);
    disturb(bundle);
    const auto covariance = refineRecallBundle(bundle);
    ASSERT_TRUE(covariance.has_value());
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(bundle.views[0].R * kPresent.R.transpose()));
    Eigen::Matrix<double, 6, 1> error;
    error << turn.angle() * turn.axis(), bundle.views[0].t - kPresent.t;
    const Eigen::Matrix<double, 6, 6> of_present = covariance->topLeftCorner<6, 6>();
    sum += error.dot(of_present.ldlt().solve(error));
  }
  // Chi-square with 6 degrees of freedom: mean 6; of 60 trials' mean the standard deviation is 0.45.
  EXPECT_NEAR(sum / kTrials, 6.0, 1.8);
}

TEST(RecallBundle, OutliersAreMarkedAndDoNotPull) {
  RecallBundle bundle = scene(4, 0.0);
  disturb(bundle);
  for (std::size_t i = 0; i < bundle.observations.size(); i += 10) bundle.observations[i].bearing.y() += 0.05;
  ASSERT_TRUE(refineRecallBundle(bundle).has_value());
  EXPECT_NEAR((bundle.views[0].t - kPresent.t).norm(), 0.0, 1e-4);
  for (std::size_t i = 0; i < bundle.observations.size(); i += 10)
    EXPECT_FALSE(bundle.observations[i].inlier);
}

TEST(RecallBundle, TooFewObservationsGiveNothing) {
  RecallBundle bundle = scene(1, 0.0);
  bundle.observations.resize(6);
  EXPECT_FALSE(refineRecallBundle(bundle).has_value());
}

TEST(RecallConsensus, ResectionAndEpipolarFindThePoseAmongOutliers) {
  RecallBundle bundle = scene(2, 0.2);
  for (std::size_t i = 0; i < bundle.observations.size(); ++i) {
    if (i % 5 >= 2) continue;
    bundle.observations[i].bearing = Eigen::Vector2d(-0.7 + 0.006 * static_cast<double>(i),
                                                     0.2 - 0.001 * static_cast<double>((i * 37) % 400));
  }
  const auto resected = resectionConsensus(pairsOf(bundle, 0, true), 20);
  ASSERT_TRUE(resected.has_value());
  EXPECT_NEAR((resected->R - kPresent.R).norm(), 0.0, 5e-3);
  EXPECT_NEAR((resected->t - kPresent.t).norm(), 0.0, 5e-2);

  const auto epipolar = epipolarConsensus(pairsOf(bundle, 0, false), 20);
  ASSERT_TRUE(epipolar.has_value());
  EXPECT_NEAR((epipolar->R - kPresent.R).norm(), 0.0, 2e-2);
  EXPECT_GT(epipolar->t.dot(kPresent.t.normalized()), 0.98);
}

TEST(RecallConsensus, EpipolarIsExactWithoutNoise) {
  const auto view = epipolarConsensus(pairsOf(scene(3, 0.0), 0, false), 20);
  ASSERT_TRUE(view.has_value());
  EXPECT_NEAR((view->R - kPresent.R).norm(), 0.0, 1e-6);
  EXPECT_NEAR((view->t - kPresent.t.normalized()).norm(), 0.0, 1e-5);
}

TEST(RecallConsensus, NoAgreementNoPose) {
  std::vector<RecallPair> pairs = pairsOf(scene(2, 0.0), 0, true);
  EXPECT_FALSE(epipolarConsensus({pairs.begin(), pairs.begin() + 4}, 1).has_value());
  EXPECT_FALSE(resectionConsensus({pairs.begin(), pairs.begin() + 3}, 1).has_value());
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].bearing = pairs[(i * 53 + 7) % pairs.size()].anchor;
  EXPECT_FALSE(resectionConsensus(pairs, 20).has_value());
}

TEST(RecallConsensus, InverseDepthIsExactAndNeverNegative) {
  const RecallBundle bundle = scene(5, 0.0);
  for (const RecallObservation& seen : bundle.observations) {
    const RecallPoint& point = bundle.points[static_cast<std::size_t>(seen.point)];
    const RecallView& view = bundle.views[static_cast<std::size_t>(seen.view)];
    EXPECT_NEAR(inverseDepth(view, point.bearing, seen.bearing), point.inverse_depth, 1e-9);
    RecallView opposite = view;
    opposite.t *= -1.0;
    EXPECT_EQ(inverseDepth(opposite, point.bearing, seen.bearing), 0.0);
  }
}

}  // namespace
}  // namespace ratslam
