#include "ratslam/vision/bundle_adjustment.h"

#include <gtest/gtest.h>

#include <random>

#include "street_scene.h"

#ifdef RATSLAM_HAVE_CERES
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#endif

namespace ratslam {
namespace {

struct Scene {
  BundleProblem truth;
  BundleProblem start;
};

/// Eight cameras along a street, the last three fixed, and points that all of them see.
Scene makeScene(double pixel_noise) {
  const CameraModel camera = test::smallCamera();
  std::mt19937 random(11);
  std::uniform_real_distribution<double> x(-6, 6), y(-2, 1.6), z(9, 30);
  std::normal_distribution<double> normal(0.0, 1.0);
  Scene scene;
  BundleProblem& truth = scene.truth;
  truth.free_poses = 5;
  for (int i = 0; i < 8; ++i) {
    truth.poses.push_back({expRotation({0.01 * i, -0.02 * i, 0.0}), {0.05 * i, 0.01, -0.7 * (7 - i)}});
  }
  for (int point = 0; point < 120; ++point) {
    const double depth = z(random);  // arguments of one call are drawn in any order: another scene a compiler
    const double height = y(random);
    truth.points.emplace_back(x(random), height, depth);
    for (int pose = 0; pose < 8; ++pose) {
      const double noise_y = normal(random);
      const Eigen::Vector2d noise(normal(random), noise_y);
      const Eigen::Vector2d pixel =
          camera.project(truth.poses[static_cast<std::size_t>(pose)] * truth.points.back()) +
          pixel_noise * noise;
      truth.observations.push_back({pose, point, pixel, 1.0});
    }
  }
  scene.start = truth;
  for (int pose = 0; pose < truth.free_poses; ++pose) {
    Vector6 shake;
    for (int i = 0; i < 6; ++i) shake(i) = normal(random) * (i < 3 ? 0.05 : 0.005);
    RigidTransform& T = scene.start.poses[static_cast<std::size_t>(pose)];
    T = expTransform(shake) * T;
  }
  for (auto& point : scene.start.points) {
    for (int axis = 2; axis >= 0; --axis) point[axis] += 0.2 * normal(random);
  }
  return scene;
}

BundleOptions thorough() {
  BundleOptions options;
  options.max_iterations = 60;
  options.relative_decrease = 1e-12;
  return options;
}

TEST(BundleAdjustment, RestoresAnExactScene) {
  Scene scene = makeScene(0.0);
  const BundleSummary summary = adjustBundle(test::smallCamera(), scene.start, thorough());
  EXPECT_LT(summary.final_cost, 1e-8);
  for (std::size_t i = 0; i < scene.truth.poses.size(); ++i) {
    EXPECT_LT(logTransform(scene.start.poses[i] * scene.truth.poses[i].inverse()).norm(), 1e-5);
  }
  for (std::size_t i = 0; i < scene.truth.points.size(); ++i) {
    EXPECT_LT((scene.start.points[i] - scene.truth.points[i]).norm(), 1e-4);
  }
}

TEST(BundleAdjustment, NeverRaisesTheCostAndLeavesFixedPosesAlone) {
  Scene scene = makeScene(0.7);
  scene.start.observations[5].pixel += Eigen::Vector2d(60, -40);  // a wrong match
  const BundleProblem before = scene.start;
  double cost = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 6; ++round) {
    BundleOptions options;
    options.max_iterations = 1;
    const BundleSummary summary = adjustBundle(test::smallCamera(), scene.start, options);
    EXPECT_LE(summary.final_cost, summary.initial_cost);
    EXPECT_LE(summary.final_cost, cost);
    cost = summary.final_cost;
  }
  for (std::size_t i = 5; i < 8; ++i) {
    EXPECT_EQ(scene.start.poses[i].translation, before.poses[i].translation);
    EXPECT_EQ(scene.start.poses[i].rotation.coeffs(), before.poses[i].rotation.coeffs());
  }
}

TEST(BundleAdjustment, SurvivesPointsNobodySeesAndBehindCameras) {
  Scene scene = makeScene(0.3);
  scene.start.points.push_back({0, 0, 10});
  scene.start.points[3] = {0, 0, -20};
  adjustBundle(test::smallCamera(), scene.start, thorough());
  for (const auto& pose : scene.start.poses) EXPECT_TRUE(pose.translation.allFinite());
  for (const auto& point : scene.start.points) EXPECT_TRUE(point.allFinite());
}

TEST(BundleAdjustment, RefusesIndicesThatDoNotExist) {
  Scene scene = makeScene(0.0);
  scene.start.observations[0].pose = 99;
  EXPECT_THROW(adjustBundle(test::smallCamera(), scene.start, {}), std::invalid_argument);
  scene = makeScene(0.0);
  std::swap(scene.start.observations.front(), scene.start.observations.back());
  EXPECT_THROW(adjustBundle(test::smallCamera(), scene.start, {}), std::invalid_argument);
}

#ifdef RATSLAM_HAVE_CERES
struct ReprojectionCost {
  BundleObservation observation;
  CameraModel camera;
  template <class T>
  bool operator()(const T* rotation, const T* translation, const T* point, T* error) const {
    T x[3];
    ceres::QuaternionRotatePoint(rotation, point, x);
    for (int i = 0; i < 3; ++i) x[i] += translation[i];
    error[0] = (T(camera.fx) * x[0] / x[2] + T(camera.cx) - T(observation.pixel.x())) / T(observation.sigma);
    error[1] = (T(camera.fy) * x[1] / x[2] + T(camera.cy) - T(observation.pixel.y())) / T(observation.sigma);
    return true;
  }
};

void keepUnit(ceres::Problem& problem, double* quaternion) {
#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
  problem.SetManifold(quaternion, new ceres::QuaternionManifold);
#else
  problem.SetParameterization(quaternion, new ceres::QuaternionParameterization);
#endif
}

TEST(BundleAdjustment, ReachesTheMinimumThatCeresFinds) {
  Scene scene = makeScene(0.7);
  for (std::size_t i = 0; i < scene.start.observations.size(); i += 37) {
    scene.start.observations[i].pixel += Eigen::Vector2d(12, -9);  // what Huber's loss is for
  }
  std::vector<std::array<double, 4>> rotations;
  std::vector<Eigen::Vector3d> translations;
  for (const auto& pose : scene.start.poses) {
    rotations.push_back({pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()});
    translations.push_back(pose.translation);
  }
  std::vector<Eigen::Vector3d> points = scene.start.points;
  ceres::Problem problem;
  for (const auto& observation : scene.start.observations) {
    const auto pose = static_cast<std::size_t>(observation.pose);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ReprojectionCost, 2, 4, 3, 3>(
                                 new ReprojectionCost{observation, test::smallCamera()}),
                             new ceres::HuberLoss(2.0), rotations[pose].data(), translations[pose].data(),
                             points[static_cast<std::size_t>(observation.point)].data());
  }
  for (std::size_t pose = 0; pose < rotations.size(); ++pose) {
    keepUnit(problem, rotations[pose].data());
    if (static_cast<int>(pose) < scene.start.free_poses) continue;
    problem.SetParameterBlockConstant(rotations[pose].data());
    problem.SetParameterBlockConstant(translations[pose].data());
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-14;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  ceres::Solver::Summary reference;
  ceres::Solve(options, &problem, &reference);

  const BundleSummary summary = adjustBundle(test::smallCamera(), scene.start, thorough());
  EXPECT_NEAR(summary.final_cost, reference.final_cost, 1e-6 * reference.final_cost);
  for (std::size_t pose = 0; pose < translations.size(); ++pose) {
    EXPECT_LT((scene.start.poses[pose].translation - translations[pose]).norm(), 1e-4);
  }
}
#endif

}  // namespace
}  // namespace ratslam
