/// What a calibration has left of the lens: found in exact scenes, and harmless where nothing is left.
#include "ratslam/odometry/orb/lens_refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>

#include "ratslam/common/angles.h"
#include "ratslam/odometry/orb/orb_odometry.h"
#include "street_scene.h"
#include "town/drive.h"
#include "town/town.h"
#include "town/town_renderer.h"

namespace ratslam {
namespace {

/// Twelve cameras that drive round a bend, and what they see through `lens` when `believed` undistorts it.
BundleProblem bendSeenThrough(const CameraModel& lens, const CameraModel& believed) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> x(-25, 25), y(-6, 1.6), z(2, 45);
  BundleProblem problem;
  for (int i = 0; i < 12; ++i) {
    const double turn = 0.06 * i;
    const RigidTransform T_world_camera{expRotation({0.0, turn, 0.0}), {0.3 * turn * i, 0.0, 0.6 * i}};
    problem.poses.push_back(T_world_camera.inverse());
  }
  for (int point = 0; point < 600; ++point) {
    const Eigen::Vector3d place(x(random), y(random), z(random));
    std::vector<BundleObservation> seen;
    for (int pose = 0; pose < 12; ++pose) {
      const Eigen::Vector3d p = problem.poses[static_cast<std::size_t>(pose)] * place;
      if (p.z() < 2.0) continue;
      const Eigen::Vector2d ideal = lens.project(p);
      if (!(std::abs(ideal.x() - lens.cx) < lens.width)) continue;  // where no polynomial is a lens any more
      const Eigen::Vector2d raw = lens.distort(ideal);
      if (raw.x() < 0 || raw.y() < 0 || raw.x() >= lens.width || raw.y() >= lens.height) continue;
      seen.push_back({pose, static_cast<int>(problem.points.size()), believed.undistort(raw), 0.3});
    }
    if (seen.size() < 3) continue;
    problem.points.push_back(place);
    problem.observations.insert(problem.observations.end(), seen.begin(), seen.end());
  }
  return problem;
}

/// Gauss-Newton over everything, the lens included, until it stands still.
LensChange refined(const CameraModel& lens, const CameraModel& believed) {
  LensChange change = LensChange::Zero();
  RobustLoss loss;
  loss.gate = 1e9;
  loss.huber = 1e9;
  for (int round = 0; round < 8; ++round) {
    const CameraModel camera = believed.withLensChange(change);
    const LensInformation found = measureLens(camera, bendSeenThrough(lens, camera), loss);
    // What the lens model lacks leaves zeros.
    change -= found.hessian.completeOrthogonalDecomposition().solve(found.gradient);
  }
  return change;
}

TEST(LensRefinement, FindsTheErrorOfEachLensModelInAnExactScene) {
  CameraModel pinhole = test::smallCamera();
  CameraModel plumb_bob = pinhole;
  plumb_bob.model = LensModel::kPlumbBob;
  plumb_bob.coefficients = {-0.28, 0.07, 0.001, -0.0005};
  CameraModel rational = pinhole;
  rational.model = LensModel::kRationalPolynomial;
  rational.coefficients = {0.3, 0.05, 0.0, 0.0, 0.0, 0.5, 0.1, 0.0};
  CameraModel fisheye = pinhole;
  fisheye.model = LensModel::kEquidistant;
  fisheye.coefficients = {0.01, -0.004};
  for (const CameraModel& believed : {pinhole, plumb_bob, rational, fisheye}) {
    SCOPED_TRACE(static_cast<int>(believed.model));
    LensChange error(0.02, -0.009, 0.0012, -0.0017);
    if (believed.model == LensModel::kEquidistant) error.tail<2>().setZero();
    EXPECT_LT((refined(believed.withLensChange(error), believed) - error).norm(), 1e-6);
    EXPECT_LT(refined(believed, believed).norm(), 1e-9);
  }
}

TEST(LensRefinement, PointsWhoseViewsAreNearlyAllWrongSayNothing) {
  const CameraModel lens = test::smallCamera();
  const BundleProblem problem = bendSeenThrough(lens, lens);
  BundleProblem spoilt = problem;
  for (std::size_t i = 0; i < spoilt.observations.size(); ++i) {
    BundleObservation& observation = spoilt.observations[i];
    const bool first = i == 0 || spoilt.observations[i - 1].point != observation.point;
    // One view, and later two, are left of each fifth point.
    if (observation.point % 5 == 0 && !first && (observation.point < 300 || observation.pose % 3 != 0)) {
      observation.pixel.x() += 50.0;
    }
  }
  const LensInformation all = measureLens(lens, problem, RobustLoss{});
  const LensInformation rest = measureLens(lens, spoilt, RobustLoss{});
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> known(rest.hessian);
  EXPECT_GT(known.eigenvalues().minCoeff(), 0.0);
  EXPECT_LT(known.eigenvalues().maxCoeff(), 1.01 * all.hessian.trace());
  EXPECT_LT(rest.hessian.ldlt().solve(rest.gradient).norm(), 1e-6);
}

TEST(LensRefinement, ChangesOfTheLensKeepTheRest) {
  const CameraModel changed = test::smallCamera().withLensChange({0.1, 0.2, 0.3, 0.4});
  EXPECT_EQ(changed.model, LensModel::kPlumbBob);
  EXPECT_EQ(changed.coefficients, (std::vector<double>{0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(changed.fx, test::smallCamera().fx);
  CameraModel lens = test::smallCamera();
  lens.model = LensModel::kEquidistant;
  lens.coefficients = {1.0, 2.0, 3.0, 4.0};
  EXPECT_EQ(lens.withLensChange({0.5, -0.5, 0.3, 0.4}).coefficients,
            (std::vector<double>{1.5, 1.5, 3.0, 4.0}));
}

/// A drive round corners of the town, through a lens with distortion k1 that the odometry knows nothing of.
class OrbOdometryInTown : public testing::Test {
 protected:
  static constexpr int kFrames = 200;

  struct Outcome {
    double growth = 1.0;  // of the unit of length, from the first straight to the last frames
    LensChange lens = LensChange::Zero();
    std::int64_t restarts = 0;
  };

  static Outcome drive(double k1, bool refine) {
    static const Drive path = planTownDrive(kFrames);
    static const Town town(path.roads, 1);
    TownCamera lens = TownCamera::kittiLike(620, 188);
    CameraModel believed{lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy, LensModel::kNone, {}};
    lens.distortion = {k1, 0.0, 0.0, 0.0, 0.0};
    const TownRenderer renderer(town, lens);
    OrbOdometryParams params;
    params.features = 1200;
    params.ground_plane = false;
    params.refine_lens = refine;
    OrbOdometry odometry(believed, params);
    std::vector<double> ratio;
    for (int i = 0; i < kFrames; ++i) {
      const auto& pose = path.poses[static_cast<std::size_t>(i)];
      const OrbResult result = odometry.track(pose.stamp, renderer.render(pose.T_world_camera));
      if (i == 0) continue;
      const auto& before = path.poses[static_cast<std::size_t>(i) - 1];
      const double step = (pose.T_world_camera.translation() - before.T_world_camera.translation()).norm();
      ratio.push_back(result.twist.head<3>().norm() * secondsBetween(before.stamp, pose.stamp) / step);
    }
    const auto mean = [&](std::size_t from, std::size_t to) {
      double sum = 0.0;
      for (std::size_t i = from; i < to; ++i) sum += ratio[i];
      return sum / static_cast<double>(to - from);
    };
    const CameraModel& camera = odometry.camera();
    Outcome outcome;
    outcome.growth = mean(kFrames - 21, kFrames - 1) / mean(10, 30);
    outcome.restarts = odometry.restarts();
    if (camera.model != LensModel::kNone) outcome.lens = LensChange(camera.coefficients.data());
    return outcome;
  }
};

/// On a straight the images move along lines through the heading alone. Distortion then looks much like depth, and small
/// errors that all features share look like distortion.
TEST_F(OrbOdometryInTown, AStraightStreetSaysLittleOfTheLens) {
  const auto file = std::filesystem::temp_directory_path() / "lens_refinement_straight.txt";
  std::ofstream poses(file);
  constexpr int kStraight = 100;
  constexpr int kCorner = 18;
  constexpr double kStep = 0.8;
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  // x, z
  for (int i = 0; i < kStraight + kCorner + 30; ++i) {
    const double turned = 0.5 * kPi * std::clamp(i - kStraight, 0, kCorner) / kCorner;
    const Eigen::Vector2d ahead(std::sin(turned), std::cos(turned));
    poses << ahead.y() << " 0 " << ahead.x() << ' ' << at.x() << " 0 1 0 0 " << -ahead.x() << " 0 "
          << ahead.y() << ' ' << at.y() << '\n';
    at += kStep * ahead;
  }
  poses.close();
  Drive path = loadDrive(file.string(), "", 0);
  std::filesystem::remove(file);
  const Town town(path.roads, 1);
  settleOnRoad(path, town.roads());
  const TownCamera lens = TownCamera::kittiLike(620, 188);
  const TownRenderer renderer(town, lens);
  OrbOdometryParams params;
  OrbOdometry odometry({lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy, LensModel::kNone, {}},
                       params);
  std::vector<double> speeds;
  for (const DrivePose& pose : path.poses) {
    speeds.push_back(odometry.track(pose.stamp, renderer.render(pose.T_world_camera)).sample.speed);
    if (speeds.size() == kStraight) {
      EXPECT_EQ(odometry.camera().model, LensModel::kNone);
    }
  }
  const auto mean = [](auto from, auto to) {
    return std::accumulate(from, to, 0.0) / static_cast<double>(to - from);
  };
  EXPECT_NEAR(mean(speeds.end() - 15, speeds.end()),
              mean(speeds.begin() + kStraight - 40, speeds.begin() + kStraight), 0.05 * kStep / 0.1);
}

TEST_F(OrbOdometryInTown, AnUnknownBendOfTheLensDoesNotStretchTheUnitOfLength) {
  const Outcome refined = drive(0.03, true);
  EXPECT_EQ(refined.restarts, 0);
  EXPECT_NEAR(refined.growth, 1.0, 0.08);
  // At the corners the lens must come out right, whichever coefficient it is put into.
  constexpr double kR2 = 0.8;
  EXPECT_NEAR(refined.lens.x() + refined.lens.y() * kR2, 0.03, 0.01);
  EXPECT_GT(drive(0.03, false).growth, 1.6);
}

TEST_F(OrbOdometryInTown, AGoodCalibrationIsLeftAlone) {
  const Outcome refined = drive(0.0, true);
  EXPECT_EQ(refined.lens, LensChange::Zero().eval());
  EXPECT_NEAR(refined.growth, 1.0, 0.03);
}

}  // namespace
}  // namespace ratslam
