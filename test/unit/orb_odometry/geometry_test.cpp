/// Parts that are geometry alone, on exact scenes of points.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <random>
#include <utility>

#include "ratslam/camera/camera_model.h"
#include "ratslam/vision/essential_matrix.h"
#include "ratslam/vision/pose_refinement.h"
#include "ratslam/vision/rigid_transform.h"
#include "ratslam/vision/triangulation.h"
#include "ratslam/vision/two_view.h"
#include "street_scene.h"

namespace ratslam {
namespace {

using test::smallCamera;

std::vector<Eigen::Vector3d> scatteredPoints(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(-6, 6), y(-2, 1.6), z(5, 30);
  std::vector<Eigen::Vector3d> points;
  // In braces: compilers disagree about the order of arguments in parentheses, and so about the scene.
  for (int i = 0; i < count; ++i) points.push_back(Eigen::Vector3d{x(random), y(random), z(random)});
  return points;
}

double angleBetween(const RigidTransform& a, const RigidTransform& b) {
  return logRotation(a.rotation * b.rotation.conjugate()).norm();
}

TEST(RigidTransform, LogUndoesExpForSmallAndLargeTurns) {
  for (const double angle : {0.0, 1e-9, 1e-5, 1e-3, 0.5, 3.1}) {
    Vector6 twist;
    twist << 1.0, -2.0, 0.5, 0.6 * angle, -0.48 * angle, 0.64 * angle;
    EXPECT_LT((logTransform(expTransform(twist)) - twist).norm(), 1e-9) << angle;
  }
}

TEST(RigidTransform, LongProductsStayRotations) {
  Vector6 twist;
  twist << 0.1, 0.0, 0.0, 0.01, 0.02, -0.03;
  RigidTransform product;
  for (int i = 0; i < 200000; ++i) product = expTransform(twist) * product;
  EXPECT_NEAR(product.rotation.norm(), 1.0, 1e-12);
  EXPECT_LT(((product.inverse() * product).translation).norm(), 1e-6);
}

struct Lens {
  LensModel model;
  std::vector<double> coefficients;
};

class CameraLens : public testing::TestWithParam<Lens> {
 protected:
  CameraModel camera() const {
    CameraModel camera = smallCamera();
    camera.model = GetParam().model;
    camera.coefficients = GetParam().coefficients;
    return camera;
  }
};

TEST_P(CameraLens, UndistortIsTheInverseOfDistort) {
  const CameraModel lens = camera();
  for (int v = 0; v < lens.height; v += 20) {
    for (int u = 0; u < lens.width; u += 20) {
      const Eigen::Vector2d raw(u, v);
      EXPECT_LT((lens.distort(lens.undistort(raw)) - raw).norm(), 1e-6);
    }
  }
}

TEST_P(CameraLens, AGuessChangesNothingButTheWayToTheUndistortedPoint) {
  const CameraModel lens = camera();
  for (int v = 0; v < lens.height; v += 20) {
    for (int u = 0; u < lens.width; u += 20) {
      const Eigen::Vector2d pixel = lens.undistort(Eigen::Vector2d(u, v));
      const Eigen::Vector2d guess = pixel + Eigen::Vector2d(0.4, -0.3);
      EXPECT_LT((lens.undistort({u, v}, guess) - pixel).norm(), 1e-6) << u << ' ' << v;
    }
  }
}

TEST_P(CameraLens, AgreesWithOpenCv) {
  const CameraModel lens = camera();
  const std::vector<cv::Point3d> bearings = {{0.3, -0.2, 1}, {-0.6, 0.1, 1}, {0.02, 0.2, 1}};
  const cv::Matx33d k(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
  std::vector<cv::Point2d> expected;
  if (lens.model == LensModel::kEquidistant) {
    cv::fisheye::projectPoints(bearings, expected, cv::Vec3d(), cv::Vec3d(), k, lens.coefficients);
  } else {
    cv::projectPoints(bearings, cv::Vec3d(), cv::Vec3d(), k, lens.coefficients, expected);
  }
  for (std::size_t i = 0; i < bearings.size(); ++i) {
    const Eigen::Vector2d raw = lens.distort(lens.project({bearings[i].x, bearings[i].y, 1.0}));
    EXPECT_NEAR(raw.x(), expected[i].x, 1e-9);
    EXPECT_NEAR(raw.y(), expected[i].y, 1e-9);
  }
}

TEST_P(CameraLens, JacobianIsTheNumericalOne) {
  const CameraModel lens = camera();
  const Eigen::Vector2d at(320, 40);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = 1e-3 * Eigen::Vector2d::Unit(axis);
    const Eigen::Vector2d numerical = (lens.distort(at + step) - lens.distort(at - step)) / 2e-3;
    EXPECT_LT((lens.distortWithJacobian(at).jacobian.col(axis) - numerical).norm(), 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(Models, CameraLens,
                         testing::Values(Lens{LensModel::kPlumbBob, {-0.28, 0.07, 0.0002, -0.0001, 0.01}},
                                         Lens{LensModel::kRationalPolynomial,
                                              {0.2, -0.1, 0.001, 0.0005, 0.02, 0.45, -0.05, 0.01}},
                                         Lens{LensModel::kEquidistant, {-0.02, 0.004, -0.003, 0.0006}}));

TEST(CameraModel, NamesWhatIsWrong) {
  CameraModel camera = smallCamera();
  camera.fx = 0.0;
  EXPECT_THROW(camera.validate(), std::invalid_argument);
  camera = smallCamera();
  camera.coefficients = {0.1};
  EXPECT_THROW(camera.validate(), std::invalid_argument);
  camera = smallCamera();
  camera.cx = std::nan("");
  EXPECT_THROW(camera.validate(), std::invalid_argument);
  EXPECT_THROW(lensModelFromName("mirror_ball"), std::invalid_argument);
}

TEST(Reprojection, JacobianIsTheNumericalOne) {
  const CameraModel camera = smallCamera();
  const RigidTransform pose{expRotation({0.1, -0.2, 0.05}), {0.3, -0.1, 0.4}};
  const Eigen::Vector3d point(1.0, 0.5, 7.0);
  const Eigen::Vector2d pixel(250, 80);
  const Eigen::Vector3d x = pose * point;
  const auto analytical = reproject(camera, x, pixel).byPose(x);
  for (int axis = 0; axis < 6; ++axis) {
    const Vector6 step = 1e-6 * Vector6::Unit(axis);
    const Eigen::Vector2d forth = reproject(camera, expTransform(step) * pose * point, pixel).error;
    const Eigen::Vector2d back = reproject(camera, expTransform(-step) * pose * point, pixel).error;
    EXPECT_LT((analytical.col(axis) - (forth - back) / 2e-6).norm(), 1e-4) << axis;
  }
}

TEST(PoseRefinement, FindsTheExactPoseDespiteAThirdOfWrongMatches) {
  const CameraModel camera = smallCamera();
  const RigidTransform truth{expRotation({0.02, -0.05, 0.01}), {0.1, -0.05, 0.8}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(0, 160);
  std::vector<PoseObservation> observations;
  const auto points = scatteredPoints(150, 1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Vector2d pixel = camera.project(truth * points[i]);
    if (i % 3 == 0) pixel = {3 * anywhere(random), anywhere(random)};
    observations.push_back({points[i], pixel, 1.0});
  }
  const PoseEstimate estimate = refinePose(camera, RigidTransform{}, observations, RobustLoss{});
  EXPECT_LT(angleBetween(estimate.T_camera_world, truth), 1e-6);
  EXPECT_LT((estimate.T_camera_world.translation - truth.translation).norm(), 1e-5);
  EXPECT_EQ(estimate.inliers, 100);
}

TEST(PoseRefinement, EstimatesTheNoiseItself) {
  const CameraModel camera = smallCamera();
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.8);
  std::vector<PoseObservation> observations;
  for (const auto& point : scatteredPoints(400, 2)) {
    observations.push_back(
        {point, camera.project(point) + Eigen::Vector2d{noise(random), noise(random)}, 1.0});
  }
  const PoseEstimate estimate = refinePose(camera, RigidTransform{}, observations, RobustLoss{});
  EXPECT_NEAR(estimate.sigma, 0.8, 0.08);
  // The covariance must speak of errors of the size that occur.
  const Vector6 error = logTransform(estimate.T_camera_world);
  const double mahalanobis = error.dot(estimate.covariance.inverse() * error);
  EXPECT_LT(mahalanobis, 30.0);
  EXPECT_GT(mahalanobis, 0.3);
}

/// Mean of error^T covariance^-1 error over many trials; 6 where the covariance is right. Errors of pixels have
/// a part of their own and one that all points in an eighth of the image's width share.
double meanNormalisedError(double own_sigma, double shared_sigma) {
  constexpr int kTrials = 100;
  const CameraModel camera = smallCamera();
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  double sum = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::map<std::pair<int, int>, Eigen::Vector2d> shared;
    std::vector<PoseObservation> observations;
    for (const auto& point : scatteredPoints(400, 100u + static_cast<unsigned>(trial))) {
      const Eigen::Vector2d pixel = camera.project(point);
      const std::pair<int, int> region(static_cast<int>(pixel.x() * 8.0 / camera.width),
                                       static_cast<int>(pixel.y() * 4.0 / camera.height));
      if (shared.count(region) == 0) shared[region] = {normal(random), normal(random)};
      const Eigen::Vector2d own{normal(random), normal(random)};
      observations.push_back({point, pixel + shared_sigma * shared[region] + own_sigma * own, 1.0});
    }
    const PoseEstimate estimate = refinePose(camera, RigidTransform{}, observations, RobustLoss{});
    const Vector6 error = logTransform(estimate.T_camera_world);
    sum += error.dot(estimate.covariance.inverse() * error);
  }
  return sum / kTrials;
}

TEST(PoseRefinement, CovarianceIsThatOfItsErrors) { EXPECT_NEAR(meanNormalisedError(0.8, 0.0), 6.0, 1.5); }

TEST(PoseRefinement, CovarianceGrowsWhereErrorsOfNeighboursAgree) {
  // The inverse of the normal equations alone claims a covariance twenty times too small (123 here).
  EXPECT_LT(meanNormalisedError(0.3, 0.5), 40.0);
}

TEST(Triangulation, FindsExactPointsAndRefusesParallelRays) {
  const CameraModel camera = smallCamera();
  const RigidTransform second{Eigen::Quaterniond::Identity(), {-0.5, 0.0, -0.8}};
  for (const auto& point : scatteredPoints(50, 4)) {
    const std::vector<View> views = {{RigidTransform{}, camera.project(point), 1.0},
                                     {second, camera.project(second * point), 1.0}};
    const auto found = triangulate(camera, views);
    ASSERT_TRUE(found);
    EXPECT_LT((*found - point).norm(), 1e-5 * point.norm());
  }
  const std::vector<View> same_place = {{RigidTransform{}, {200, 80}, 1.0},
                                        {RigidTransform{}, {200, 80}, 1.0}};
  EXPECT_FALSE(triangulate(camera, same_place));
}

/// Bearings of scattered points in two views, off by `noise`; every third pair is of two different points.
std::vector<BearingPair> pairsWithOutliers(const RigidTransform& T, double noise, unsigned seed = 4) {
  std::vector<BearingPair> pairs;
  std::mt19937 generator(seed);
  std::normal_distribution<double> error(0.0, noise);
  const auto points = scatteredPoints(150, 7);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d& other = points[i % 3 == 0 ? (i + 50) % points.size() : i];
    const Eigen::Vector2d seen = (T * other).hnormalized();
    pairs.push_back(
        {points[i].hnormalized(), seen + Eigen::Vector2d{error(generator), error(generator)}, noise});
  }
  return pairs;
}

RigidTransform turnInABend() {
  return {expRotation({0.01, -0.2, 0.05}), Eigen::Vector3d(1.0, -0.1, -1.2).normalized()};
}

Eigen::Matrix3d essentialOf(const RigidTransform& T) {
  return skew(T.translation) * T.rotation.toRotationMatrix() / std::sqrt(2.0);
}

/// An essential matrix has no sign.
double difference(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return std::min((a - b).norm(), (a + b).norm());
}

TEST(EssentialMatrix, IsThatOfMostPairs) {
  const auto essential = essentialConsensus(pairsWithOutliers(turnInABend(), 1e-9), 80, ConsensusParams{});
  ASSERT_TRUE(essential);
  EXPECT_NEAR(essential->norm(), 1.0, 1e-12);
  EXPECT_LT(difference(*essential, essentialOf(turnInABend())), 1e-5);
}

TEST(EssentialMatrix, IsAsGoodAsItsBestSample) {
  // About 130 of 1000 samples are clean. Any of them may be off by 0.1, the best of 7 by 0.05, the best of all by 0.01.
  for (unsigned noise = 0; noise < 5; ++noise) {
    const auto essential =
        essentialConsensus(pairsWithOutliers(turnInABend(), 2e-4, noise), 80, {0.99, 1000, 1000});
    ASSERT_TRUE(essential);
    EXPECT_LT(difference(*essential, essentialOf(turnInABend())), 0.02) << "noise " << noise;
  }
}

TEST(EssentialMatrix, ContainsItsMotion) {
  const RigidTransform truth = turnInABend();
  const Eigen::Matrix3d expected = essentialOf(truth);
  int near_truth = 0;
  for (const RigidTransform& motion : decomposeEssential(expected)) {
    EXPECT_NEAR(motion.translation.norm(), 1.0, 1e-12);
    EXPECT_LT(difference(essentialOf(motion), expected), 1e-9);
    if (angleBetween(motion, truth) < 1e-9 && (motion.translation - truth.translation).norm() < 1e-9)
      ++near_truth;
  }
  EXPECT_EQ(near_truth, 1);
}

TEST(EssentialMatrix, NeedsSixPairsAndAsManyAsAreAskedFor) {
  const auto pairs = pairsWithOutliers({expRotation({0.0, 0.1, 0.0}), Eigen::Vector3d::UnitX()}, 2e-4);
  EXPECT_FALSE(essentialConsensus({pairs.begin(), pairs.begin() + 5}, 0, ConsensusParams{}));
  EXPECT_FALSE(essentialConsensus(pairs, 149, ConsensusParams{}));
}

struct TwoViewScene {
  std::vector<Eigen::Vector2d> first;
  std::vector<Eigen::Vector2d> second;
};

TwoViewScene view(const CameraModel& camera, const std::vector<Eigen::Vector3d>& points,
                  const RigidTransform& T) {
  TwoViewScene scene;
  for (const auto& point : points) {
    scene.first.push_back(camera.project(point));
    scene.second.push_back(camera.project(T * point));
  }
  return scene;
}

TEST(TwoView, FindsTheMotionThroughAScatteredScene) {
  const CameraModel camera = smallCamera();
  const RigidTransform truth{expRotation({0.01, -0.04, 0.005}), Eigen::Vector3d(1.0, -0.1, -1.2)};
  const TwoViewScene scene = view(camera, scatteredPoints(200, 6), truth);
  const auto motion = estimateTwoViewMotion(camera, scene.first, scene.second, TwoViewParams{});
  ASSERT_TRUE(motion);
  EXPECT_LT(angleBetween(motion->T_second_first, truth), 1e-3);
  EXPECT_LT((motion->T_second_first.translation - truth.translation.normalized()).norm(), 5e-3);
}

TEST(TwoView, FindsTheMotionOverAFlatScene) {
  const CameraModel camera = smallCamera();
  std::vector<Eigen::Vector3d> points = scatteredPoints(200, 8);
  for (auto& point : points) point.z() = 9.0 + 0.3 * point.x() - 0.2 * point.y();
  const RigidTransform truth{expRotation({0.0, 0.1, 0.0}), Eigen::Vector3d(-1.0, 0.1, 0.2)};
  const TwoViewScene scene = view(camera, points, truth);
  const auto motion = estimateTwoViewMotion(camera, scene.first, scene.second, TwoViewParams{});
  ASSERT_TRUE(motion);
  EXPECT_LT(angleBetween(motion->T_second_first, truth), 5e-3);
  EXPECT_LT((motion->T_second_first.translation - truth.translation.normalized()).norm(), 3e-2);
}

TEST(TwoView, RefusesPureRotationAndTinyBaselines) {
  const CameraModel camera = smallCamera();
  const auto points = scatteredPoints(200, 9);
  for (const double baseline : {0.0, 0.01}) {
    const RigidTransform T{expRotation({0.0, 0.05, 0.0}), Eigen::Vector3d(0, 0, -baseline)};
    const TwoViewScene scene = view(camera, points, T);
    EXPECT_FALSE(estimateTwoViewMotion(camera, scene.first, scene.second, TwoViewParams{})) << baseline;
  }
}

}  // namespace
}  // namespace ratslam
