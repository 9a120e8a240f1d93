#include "ratslam/experience_map/solver/recall_spread.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ratslam {
namespace {

constexpr double kStep = 5.0;         // distance between recalls [m]
constexpr double kCorrelation = 0.8;  // of the errors along the street of consecutive recalls
constexpr double kSigma = 2.0;        // of the errors [m]

Constraint recallAt(double apart) {
  Constraint recall;
  recall.recall = recall.vague = true;
  recall.apart = apart;
  return recall;
}

/// A street that is recalled along its whole length. Errors along it are correlated, errors across it are not.
/// @param false_recalls of them, number of those that are far off
RecallSpread learnedOn(std::size_t recalls, std::size_t false_recalls = 0) {
  RecallSpread spread(0.0, 0.3);
  for (int k = 0; k < 20; ++k) spread.addSpacing(6.0);
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, kSigma);
  PoseGraph graph(10.0);
  double along = normal(random);
  for (std::size_t k = 0; k < recalls; ++k) {
    Constraint recall = recallAt(kStep);
    MapPose place;
    place.x = kStep * static_cast<double>(k);
    recall.from = graph.addNode(place);
    place.x += along;
    place.y += normal(random) + (k < false_recalls ? 1e4 : 0.0);
    recall.to = graph.addNode(place);
    spread.weigh(recall);
    graph.addConstraint(recall);
    along = kCorrelation * along + std::sqrt(1.0 - kCorrelation * kCorrelation) * normal(random);
  }
  EXPECT_TRUE(spread.learn(graph));
  return spread;
}

TEST(RecallSpread, RecallsThatShareTheirErrorsTellNoMoreThanTheyKnow) {
  const RecallSpread spread = learnedOn(2000);
  Constraint alone = recallAt(1000.0);
  Constraint next = recallAt(kStep);
  spread.weigh(alone);
  spread.weigh(next);
  EXPECT_NEAR(alone.xy_weight(0, 0) * kSigma, 1.0, 0.15);
  EXPECT_NEAR(alone.xy_weight(1, 1) * kSigma, 1.0, 0.15);
  // The information of one more value of a first-order autoregression about its mean.
  const double told = std::pow(next.xy_weight(0, 0) / alone.xy_weight(0, 0), 2);
  EXPECT_NEAR(told, (1.0 - kCorrelation) / (1.0 + kCorrelation), 0.03);
  EXPECT_GT(next.xy_weight(1, 1), 0.9 * alone.xy_weight(1, 1));
}

TEST(RecallSpread, NoRecallIsWeakerThanTheFirstGuess) {
  const RecallSpread spread = learnedOn(2000);
  Constraint again = recallAt(0.0);
  spread.weigh(again);
  EXPECT_EQ(again.xy_weight(0, 0), 1.0 / spread.place());
}

/// Where recalls contradict the map it is the map that is bent, and its tension is no error of the recalls.
TEST(RecallSpread, AMapThatDisagreesTellsNothingOfTheirCorrelation) {
  const RecallSpread spread = learnedOn(2000, 400);
  Constraint alone = recallAt(1000.0);
  Constraint next = recallAt(kStep);
  spread.weigh(alone);
  spread.weigh(next);
  EXPECT_EQ(next.xy_weight(0, 0), alone.xy_weight(0, 0));
}

TEST(RecallSpread, TheKernelKeepsItsWidthInMetres) {
  const RecallSpread spread = learnedOn(200);
  for (const double apart : {0.0, kStep, 1000.0}) {
    Constraint recall = recallAt(apart);
    spread.weigh(recall);
    EXPECT_NEAR(recall.doubt / recall.xy_weight.diagonal().minCoeff(), spread.place(), 1e-9);
  }
}

/// Squares of ways of no length vanish, and what is divided by them is no number.
TEST(RecallSpread, WhoStandsStillTellsNothingOfHowFarAPlaceReaches) {
  RecallSpread spread(0.0, 0.3);
  for (int k = 0; k < 3; ++k) spread.addSpacing(0.6);
  const double place = spread.place();
  EXPECT_NEAR(place, 0.8, 1e-12);
  for (int k = 0; k < 50; ++k) spread.addSpacing(1e-160);
  EXPECT_EQ(spread.place(), place);
}

}  // namespace
}  // namespace ratslam
