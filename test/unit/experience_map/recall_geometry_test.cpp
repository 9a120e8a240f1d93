/// Recalls whose offset image geometry has measured: the map must use direction and heading, and only where
/// they hold.
#include <gtest/gtest.h>

#include "ratslam/experience_map/solver/pose_graph_map.h"

namespace ratslam {
namespace {

/// Experience 0 at the origin facing along x, made with geometry `at_creation`; the robot recalls it after it
/// has driven a way that the odometry knows badly.
class Recall {
 public:
  explicit Recall(const RecallGeometry* at_creation) : solver_(params()) {
    graph_.addExperience(MapPose{});
    robot_ = solver_.create(graph_, robot_, at_creation);
  }

  /// Pose of the robot relative to experience 0, given where its odometry leads it.
  MapPose recall(const RelativePose& reckoned, const RecallGeometry* geometry) {
    robot_.motion.pose = reckoned;
    robot_.motion.length = 1000.0;
    robot_ = solver_.recall(graph_, 0, robot_, 0.0, geometry).value();
    solver_.settle(graph_);
    return solver_.framePose(graph_, robot_.frame);
  }

 private:
  static ExperienceMapParams params() {
    ExperienceMapParams params;
    params.exp_odometry_sigma = 1.0;
    params.exp_rotation_sigma = 0.1;
    return params;
  }

  PoseGraphMap solver_;
  ExperienceGraph graph_;
  RobotPlace robot_;
};

RecallGeometry geometryTo(double direction, double relative, double distance = -1.0) {
  RecallGeometry geometry;
  geometry.direction_rad = direction;
  geometry.relative_rad = relative;
  geometry.distance = distance;
  geometry.sigma_rotation = 0.01;
  geometry.sigma_direction = 0.05;
  geometry.inliers = 50;
  return geometry;
}

TEST(RecallGeometry, PlainRecallIsTheSamePlaceGiveOrTakeAMetre) {
  const MapPose pose = Recall(nullptr).recall({3.0, 3.0, 0.0, 0.5}, nullptr);
  EXPECT_LT(std::hypot(pose.x, pose.y), 0.1);
  EXPECT_LT(std::abs(pose.yaw), 0.1);
}

TEST(RecallGeometry, HoldsTheHeadingAndTheDirectionButNotTheDistance) {
  const RecallGeometry left = geometryTo(kPi / 2.0, -0.2);
  Recall plain(nullptr);
  Recall measured(nullptr);
  const RelativePose reckoned{1.5, 1.5, 0.0, 0.3};
  const MapPose vague = plain.recall(reckoned, nullptr);
  const MapPose sharp = measured.recall(reckoned, &left);
  EXPECT_NEAR(sharp.yaw, -0.2, 0.01);
  EXPECT_LT(std::abs(sharp.x), 0.2 * std::abs(vague.x) + 1e-4);
  EXPECT_GT(sharp.y, 0.5 * vague.y);
}

TEST(RecallGeometry, UsesADistanceWhereThereIsOne) {
  const RecallGeometry ahead = geometryTo(0.0, 0.0, 2.5);
  const MapPose pose = Recall(nullptr).recall({0.0, 0.0, 0.0, 0.0}, &ahead);
  EXPECT_NEAR(pose.x, 2.5, 0.05);
  EXPECT_NEAR(pose.y, 0.0, 0.05);
}

/// The experience was created 2 m left of where the template was learned, turned by 0.4 rad.
TEST(RecallGeometry, IsCarriedOverToAnExperienceOfKnownOffset) {
  const RecallGeometry at_creation = geometryTo(kPi / 2.0, 0.4, 2.0);
  const RecallGeometry now = geometryTo(0.0, 0.1, 3.0);
  const MapPose pose = Recall(&at_creation).recall({1.0, 0.0, 0.0, 0.0}, &now);
  // In the template's axes the robot is at (3, 0), the experience at (0, 2), facing 0.4.
  const double c = std::cos(-0.4);
  const double s = std::sin(-0.4);
  EXPECT_NEAR(pose.x, c * 3.0 - s * -2.0, 0.1);
  EXPECT_NEAR(pose.y, s * 3.0 + c * -2.0, 0.1);
  EXPECT_NEAR(pose.yaw, 0.1 - 0.4, 0.01);
}

TEST(RecallGeometry, GivesOnlyTheHeadingWhereTheOffsetIsUnknown) {
  const RecallGeometry at_creation = geometryTo(kPi / 2.0, 0.4);
  const RecallGeometry now = geometryTo(0.0, 0.1, 3.0);
  const MapPose with = Recall(&at_creation).recall({2.0, 1.0, 0.0, 0.0}, &now);
  const MapPose without = Recall(&at_creation).recall({2.0, 1.0, 0.0, 0.0}, nullptr);
  EXPECT_NEAR(with.yaw, 0.1 - 0.4, 0.01);
  EXPECT_NEAR(with.x, without.x, 0.02);
  EXPECT_NEAR(with.y, without.y, 0.02);
}

RecallGeometry aheadBy(double ahead) {
  RecallGeometry geometry;
  geometry.ahead = ahead;
  return geometry;
}

TEST(RecallGeometry, TakesWhatTheViewsAroundSayOfTheWayWhereImagesMeasuredNothing) {
  const RecallGeometry behind = aheadBy(-0.4);
  const MapPose pose = Recall(nullptr).recall({3.0, 3.0, 0.0, 0.5}, &behind);
  EXPECT_NEAR(pose.x, -0.4, 0.1);
  EXPECT_NEAR(pose.y, 0.0, 0.1);
}

TEST(RecallGeometry, CountsFromWhereTheExperienceWasMade) {
  const RecallGeometry then = aheadBy(0.3);
  const RecallGeometry now = aheadBy(-0.2);
  EXPECT_NEAR(Recall(&then).recall({3.0, 3.0, 0.0, 0.5}, &now).x, -0.5, 0.1);
}

}  // namespace
}  // namespace ratslam
