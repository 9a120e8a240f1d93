#include "ratslam/experience_map/motion_error.h"

#include <gtest/gtest.h>

#include <random>

#include "ratslam/experience_map/map_pose.h"

namespace ratslam {
namespace {

OdometryStep arcStep(double share) {
  OdometryStep step;
  step.dt = share;
  step.forward = 2.0 * share;
  step.rotation = 0.2 * share;
  step.covariance = StepCovariance(Eigen::Vector4d(4e-4, 1e-4, 1e-4, 1e-4).asDiagonal()) * share;
  return step;
}

/// The covariance is that of motions whose steps are disturbed as their covariance says.
TEST(MotionError, IsTheSpreadOfDisturbedMotions) {
  constexpr int kSteps = 12;
  constexpr int kMotions = 20000;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Motion mean;
  for (int i = 0; i < kSteps; ++i) mean.add(arcStep(1.0));
  Eigen::Matrix4d spread = Eigen::Matrix4d::Zero();
  for (int k = 0; k < kMotions; ++k) {
    Motion motion;
    for (int i = 0; i < kSteps; ++i) {
      OdometryStep step = arcStep(1.0);
      const Eigen::Vector4d sigma = step.covariance->diagonal().cwiseSqrt();
      step.forward += sigma[0] * normal(random);
      step.left += sigma[1] * normal(random);
      step.up += sigma[2] * normal(random);
      step.rotation += sigma[3] * normal(random);
      motion.add(step);
    }
    const Eigen::Vector4d off(motion.pose.x - mean.pose.x, motion.pose.y - mean.pose.y,
                              motion.pose.z - mean.pose.z, wrapAngle(motion.pose.yaw - mean.pose.yaw));
    spread += off * off.transpose() / kMotions;
  }
  const double size = spread.diagonal().maxCoeff();
  EXPECT_LT((spread - mean.error.covariance).cwiseAbs().maxCoeff(), 0.05 * size) << spread << "\n\n"
                                                                                 << mean.error.covariance;
}

/// However a way is divided into steps, its unit of length is as well known.
TEST(MotionError, TheUnitDoesNotDependOnHowTheWayIsDivided) {
  for (const auto& unit :
       {UnitOfLength{0.02, 0.003}, UnitOfLength{std::nullopt, 0.003}, UnitOfLength{0.02, 0.0}}) {
    MotionError whole;
    OdometryStep step = arcStep(1.0);
    step.unit = unit;
    whole.add(step, 1.0, 0.0, 40.0);
    MotionError parts;
    for (int i = 0; i < 80; ++i) parts.add(step, 1.0, 0.0, 0.5);
    EXPECT_NEAR(parts.scale_kept, whole.scale_kept, 1e-12);
    EXPECT_NEAR(parts.scale_variance, whole.scale_variance, 1e-15);
    EXPECT_EQ(whole.said_scale_length, whole.length);
  }
}

/// An anchored unit never strays further than its anchor allows, one that is not goes on and on.
TEST(MotionError, AnAnchoredUnitStaysNearTheTrueOne) {
  MotionError anchored;
  MotionError free;
  OdometryStep step = arcStep(1.0);
  step.unit = UnitOfLength{0.02, 0.003};
  anchored.add(step, 1.0, 0.0, 1e4);
  step.unit->anchor_sigma.reset();
  free.add(step, 1.0, 0.0, 1e4);
  EXPECT_NEAR(std::sqrt(anchored.scale_variance), 0.02, 1e-6);
  EXPECT_NEAR(std::sqrt(free.scale_variance), 0.3, 1e-6);
  OdometryStep metric = arcStep(1.0);
  metric.unit = UnitOfLength{0.0, 0.0};
  MotionError known;
  known.add(metric, 1.0, 0.0, 1e4);
  EXPECT_EQ(known.scale_variance, 0.0);
}

TEST(MotionError, AUnitChosenAnewHasNothingToDoWithTheOneBefore) {
  MotionError error;
  OdometryStep step = arcStep(1.0);
  step.unit = UnitOfLength{0.02, 0.003};
  step.new_unit = true;
  error.add(step, 1.0, 0.0, 1.0);
  EXPECT_EQ(error.scale_kept, 0.0);
  EXPECT_NEAR(std::sqrt(error.scale_variance), 0.02, 1e-3);
}

}  // namespace
}  // namespace ratslam
