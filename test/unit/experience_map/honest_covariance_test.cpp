/// The covariance of the map's poses is as large as their errors are.
#include <gtest/gtest.h>

#include "oracle/experience_map_drive.h"
#include "ratslam/common/state.h"

namespace ratslam {
namespace {

struct Honesty {
  double mean = 0.0;       ///< of the normalised error squared of (x, y, yaw), 3 where it is honest
  double within_95 = 0.0;  ///< share of the poses whose error lies in its 95 % band
  std::size_t poses = 0;
};

/// Drives through a city with an odometry whose steps are disturbed as it says.
Honesty drive(unsigned seed, double recall_share) {
  CityDrive city;
  city.experiences = 900;
  city.recall_share = recall_share;
  city.seed = seed;
  auto steps = simulate(city);
  std::mt19937 random(seed + 100);
  std::normal_distribution<double> normal;
  constexpr double kForward = 0.02;
  constexpr double kLeft = 0.005;
  constexpr double kTurn = 0.003;
  ExperienceMapParams params;
  params.exp_initial_em_deg = 0.0;
  ExperienceMap map(params);
  map.start(steps.front().end);
  Honesty honesty;
  std::size_t within = 0;
  Pose2 start;
  for (std::size_t k = 1; k < steps.size(); ++k) {
    OdometryStep step = steps[k].motion;
    if (k > 1) {  // the first place of the map is exact
      step.forward += kForward * normal(random);
      step.left += kLeft * normal(random);
      step.rotation += kTurn * normal(random);
    }
    step.covariance = StepCovariance(Eigen::Vector4d(kForward, kLeft, kLeft, kTurn).cwiseAbs2().asDiagonal());
    step.unit = UnitOfLength{0.0, 0.0};
    map.integrate(steps[k].end, step);
    map.apply(steps[k].action);
    if (k == 1) {
      const MapPose first = map.robotPose();
      start = compose({first.x, first.y, first.yaw}, between(steps[k].truth, {0.0, 0.0, 0.0}));
      continue;
    }
    if (k % 20 != 0) continue;  // errors of poses close to each other are one error
    map.settle();
    const Pose2 truth = compose(start, steps[k].truth);
    const MapPose robot = map.robotPose();
    const Eigen::Vector3d off(robot.x - truth.x, robot.y - truth.y, wrapAngle(robot.yaw - truth.th));
    const Eigen::Matrix4d all = *map.robotCovariance();
    Eigen::Matrix3d covariance;
    const int parts[] = {0, 1, 3};
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) covariance(row, column) = all(parts[row], parts[column]);
    }
    const double squared = off.dot(covariance.inverse() * off);
    honesty.mean += squared;
    ++honesty.poses;
    if (squared < 9.348) ++within;  // chi^2 of 3: a pose that is better known than it says does no harm
  }
  honesty.mean /= static_cast<double>(honesty.poses);
  honesty.within_95 = static_cast<double>(within) / static_cast<double>(honesty.poses);
  return honesty;
}

TEST(HonestCovariance, ErrorsLieWithinTheirBand) {
  for (const double recall_share : {0.0, 0.2}) {
    double within = 0.0;
    double mean = 0.0;
    constexpr unsigned kDrives = 15;
    for (unsigned seed = 1; seed <= kDrives; ++seed) {
      const Honesty honesty = drive(seed, recall_share);
      within += honesty.within_95 / kDrives;
      mean += honesty.mean / kDrives;
    }
    RecordProperty(recall_share > 0.0 ? "within_with_recalls" : "within_without", std::to_string(within));
    EXPECT_GT(within, 0.9) << "recalls " << recall_share << ", mean " << mean;
    EXPECT_GT(mean, 0.3) << "recalls " << recall_share << ": it is not said larger than it is";
  }
}

/// An error of the metre stretches the whole map: it is part of what is said of a pose, and of no decision.
TEST(HonestCovariance, AnErrorOfTheMetreGrowsWithTheDistanceFromTheStartAndLeavesTheMap) {
  constexpr double kMetre = 0.01;
  CityDrive city;
  city.experiences = 200;
  const auto steps = simulate(city);
  ExperienceMap exact{ExperienceMapParams()};
  ExperienceMap doubtful{ExperienceMapParams()};
  for (ExperienceMap* map : {&exact, &doubtful}) {
    map->start(steps.front().end);
    for (std::size_t k = 1; k < steps.size(); ++k) {
      OdometryStep step = steps[k].motion;
      step.covariance = StepCovariance(Eigen::Vector4d::Constant(1e-4).asDiagonal());
      step.unit = UnitOfLength{0.005, 0.001, map == &doubtful && k > 10 ? kMetre : 0.0};
      map->integrate(steps[k].end, step);
      map->apply(steps[k].action);
    }
  }
  const MapPose first = exact.graph().pose(0);
  const MapPose robot = exact.robotPose();
  EXPECT_EQ(doubtful.robotPose().x, robot.x);
  EXPECT_EQ(doubtful.robotPose().y, robot.y);
  const Eigen::Vector2d way(robot.x - first.x, robot.y - first.y);
  ASSERT_GT(way.norm(), 1.0);
  const Eigen::Matrix4d more = *doubtful.robotCovariance() - *exact.robotCovariance();
  const Eigen::Matrix2d of_place = more.topLeftCorner<2, 2>();
  const Eigen::Matrix2d of_metre = kMetre * kMetre * way * way.transpose();
  EXPECT_TRUE(of_place.isApprox(of_metre, 1e-6)) << more;
  EXPECT_EQ(more(3, 3), 0.0);

  OdometryStep absurd = steps.back().motion;
  absurd.unit = UnitOfLength{0.005, 0.001, 1e300};
  exact.integrate(steps.back().end + 100000000, absurd);
  EXPECT_TRUE(exact.robotCovariance()->allFinite());

  State state;
  doubtful.save(state);
  ExperienceMap loaded{ExperienceMapParams()};
  loaded.load(state);
  EXPECT_EQ(*loaded.robotCovariance(), *doubtful.robotCovariance());
}

}  // namespace
}  // namespace ratslam
