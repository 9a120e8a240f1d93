/// A ring of streets patrolled for very long: what the map keeps of it, and how good it stays.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "oracle/experience_map_drive.h"
#include "ratslam/common/state.h"
#include "ratslam/experience_map/experience_map.h"
#include "ratslam/experience_map/solver/uncertain_pose.h"

namespace ratslam {
namespace {

struct Patrol {
  int places = 100;
  double spacing = 4.0;        ///< [m]
  double length_noise = 0.02;  ///< of a way from place to place, relative
  double yaw_noise = 0.001;    ///< likewise [rad]
  double scale_walk = 0.0;     ///< of the log-scale, likewise
  double scatter = 0.8;        ///< of the robot about a place [m]
};

/// Laps of a ring: its places are created in the first and recalled in the others, from about where they are.
std::vector<DriveStep> patrol(const Patrol& ring, int laps) {
  std::mt19937 random(7);
  const auto uniform = [&] { return (static_cast<double>(random()) + 0.5) / 4294967296.0; };
  const auto normal = [&] {
    const double radius = std::sqrt(-2.0 * std::log(uniform()));
    return radius * std::cos(2.0 * kPi * uniform());
  };
  const double radius = ring.places * ring.spacing / (2.0 * kPi);
  std::vector<DriveStep> drive(1);
  Pose2 robot{radius, 0.0, 0.5 * kPi};
  drive[0].truth = robot;
  double log_scale = 0.0;
  for (int k = 1; k <= laps * ring.places; ++k) {
    DriveStep step;
    step.end = static_cast<Stamp>(k) * 400'000'000;
    const double angle = 2.0 * kPi * k / ring.places + ring.scatter * (uniform() - 0.5) / radius;
    const double off = radius + ring.scatter * (uniform() - 0.5);
    const Pose2 next{off * std::cos(angle), off * std::sin(angle), wrapAngle(angle + 0.5 * kPi)};
    const double dx = next.x - robot.x;
    const double dy = next.y - robot.y;
    log_scale += ring.scale_walk * normal();
    const double unit = std::exp(log_scale) * (1.0 + ring.length_noise * normal());
    // The heading turns first, then the robot moves along and across it.
    step.motion.rotation = wrapAngle(next.th - robot.th) + ring.yaw_noise * normal();
    step.motion.forward = unit * (std::cos(next.th) * dx + std::sin(next.th) * dy);
    step.motion.left = unit * (-std::sin(next.th) * dx + std::cos(next.th) * dy);
    step.truth = robot = next;
    const auto place = static_cast<std::uint32_t>((k - 1) % ring.places);
    step.action.stamp = step.end;
    step.action.kind = k <= ring.places ? ActionKind::kCreateNode : ActionKind::kCreateEdge;
    step.action.src_id = drive.back().action.dest_id;
    step.action.dest_id = place;
    drive.push_back(step);
  }
  return drive;
}

void go(ExperienceMap& map, const std::vector<DriveStep>& drive, std::size_t begin, std::size_t end) {
  if (begin == 0) map.start(drive[0].end);
  for (std::size_t k = std::max<std::size_t>(begin, 1); k < end; ++k) {
    map.integrate(drive[k].end, drive[k].motion);
    map.apply(drive[k].action);
  }
}

/// Root mean square distance of poses from the truth, once laid over it in the plane.
double error(const std::vector<Pose2>& poses, const std::vector<Pose2>& truth) {
  Eigen::MatrixXd a(2, static_cast<Eigen::Index>(poses.size()));
  Eigen::MatrixXd b(2, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t k = 0; k < poses.size(); ++k) {
    a.col(static_cast<Eigen::Index>(k)) << poses[k].x, poses[k].y;
    b.col(static_cast<Eigen::Index>(k)) << truth[k].x, truth[k].y;
  }
  const Eigen::Matrix3d laid = Eigen::umeyama(a, b, false);
  const Eigen::MatrixXd apart =
      ((laid.topLeftCorner<2, 2>() * a).colwise() + laid.topRightCorner<2, 1>()) - b;
  return std::sqrt(apart.colwise().squaredNorm().mean());
}

double mapError(const ExperienceMap& map, const std::vector<DriveStep>& drive) {
  std::vector<Pose2> poses;
  std::vector<Pose2> truth;
  for (std::uint32_t id = 0; id < map.graph().experiences().size(); ++id) {
    const MapPose& pose = map.graph().pose(id);
    poses.push_back({pose.x, pose.y, pose.yaw});
    truth.push_back(drive[id + 1].truth);
  }
  return error(poses, truth);
}

/// Of the newest steps of a path.
double pathError(const std::vector<StampedPose>& path, const std::vector<DriveStep>& drive,
                 std::size_t newest) {
  std::vector<Pose2> poses;
  std::vector<Pose2> truth;
  for (std::size_t k = path.size() - newest; k < path.size(); ++k) {
    const auto step = static_cast<std::size_t>(path[k].stamp / 400'000'000);
    poses.push_back({path[k].pose.x, path[k].pose.y, path[k].pose.yaw});
    truth.push_back(drive[step].truth);
  }
  return error(poses, truth);
}

TEST(KnownGround, APatrolledRingDoesNotGrowAndGetsNoWorse) {
  const Patrol ring;
  const auto lap = static_cast<std::size_t>(ring.places);
  const auto drive = patrol(ring, 100);
  ExperienceMap map{ExperienceMapParams{}};
  go(map, drive, 0, 1 + 3 * lap);
  const std::size_t frames = map.frames();
  map.settle();
  const double early = mapError(map, drive);
  const double early_path = pathError(map.finalTrajectory(), drive, lap);
  const double early_online = pathError(map.onlineTrajectory(), drive, lap);
  go(map, drive, 1 + 3 * lap, drive.size());
  map.settle();
  EXPECT_LE(map.frames(), frames + lap / 10);
  EXPECT_EQ(map.graph().experiences().size(), lap);
  EXPECT_LE(map.graph().links().size(), lap + 1);
  EXPECT_LT(mapError(map, drive), 1.05 * early);
  // The path on known ground is filtered, not smoothed by what came after: the same online and final.
  EXPECT_LT(pathError(map.finalTrajectory(), drive, lap), 1.25 * early_path);
  EXPECT_LT(pathError(map.onlineTrajectory(), drive, lap), 1.05 * early_online);
}

TEST(KnownGround, FollowsAUnitOfLengthThatDrifts) {
  Patrol ring;
  ring.scale_walk = 0.004;
  const auto lap = static_cast<std::size_t>(ring.places);
  const auto drive = patrol(ring, 60);
  ExperienceMapParams params;
  params.exp_scale = true;
  ExperienceMap map(params);
  go(map, drive, 0, 1 + 3 * lap);
  const double early = pathError(map.onlineTrajectory(), drive, lap);
  go(map, drive, 1 + 3 * lap, drive.size());
  map.settle();
  EXPECT_LE(map.frames(), 4 * lap);
  EXPECT_LT(pathError(map.onlineTrajectory(), drive, lap), 1.3 * early);
}

TEST(KnownGround, AFalseRecallMovesNeitherTheMapNorTheWay) {
  const Patrol ring;
  const auto lap = static_cast<std::size_t>(ring.places);
  auto drive = patrol(ring, 20);
  for (std::size_t k = 10 * lap; k < drive.size(); k += 37) {  // the opposite side
    drive[k].action.dest_id = static_cast<std::uint32_t>((k - 1 + lap / 2) % lap);
  }
  ExperienceMap map{ExperienceMapParams{}};
  go(map, drive, 0, 10 * lap);
  map.settle();
  const double before = mapError(map, drive);
  go(map, drive, 10 * lap, drive.size());
  map.settle();
  EXPECT_LT(mapError(map, drive), 1.2 * before);
  EXPECT_LT(pathError(map.finalTrajectory(), drive, lap), 1.5);
}

/// Where every recall disagrees for ever, the graph still does not grow for ever.
TEST(KnownGround, RecallsThatNeverAgreeStayBounded) {
  const Patrol ring;
  const auto lap = static_cast<std::size_t>(ring.places);
  auto drive = patrol(ring, 20);
  for (std::size_t k = 2 * lap; k < drive.size(); ++k) {
    drive[k].action.dest_id = static_cast<std::uint32_t>((k * 7919) % lap);
    if (drive[k].action.dest_id == drive[k - 1].action.dest_id) drive[k].action.kind = ActionKind::kNone;
  }
  ExperienceMap map{ExperienceMapParams{}};
  for (std::size_t k = 0; k < drive.size(); ++k) {
    if (k == 0) {
      map.start(drive[0].end);
      continue;
    }
    map.integrate(drive[k].end, drive[k].motion);
    if (map.currentExperience() == drive[k].action.dest_id) continue;
    map.apply(drive[k].action);
    ASSERT_TRUE(std::isfinite(map.robotPose().x));
  }
  EXPECT_LE(map.frames(), 8 * lap + 1);
}

TEST(KnownGround, GoesOnFromAnySavedState) {
  const Patrol ring;
  const auto lap = static_cast<std::size_t>(ring.places);
  const auto drive = patrol(ring, 9);
  ExperienceMap whole{ExperienceMapParams{}};
  go(whole, drive, 0, drive.size());
  State end;
  whole.save(end);
  for (const std::size_t at : {2 * lap + 5, 3 * lap + 10, 4 * lap + 77, 7 * lap}) {
    ExperienceMap first{ExperienceMapParams{}};
    go(first, drive, 0, at);
    State state;
    first.save(state);
    ExperienceMap second{ExperienceMapParams{}};
    second.load(State::fromBytes(state.toBytes()));
    go(second, drive, at, drive.size());
    State reached;
    second.save(reached);
    EXPECT_TRUE(reached == end) << "saved after step " << at;
  }
}

/// Whatever the solver is doing when the robot leaves known ground for a new street, the covariance claims no more than
/// the settled map.
TEST(KnownGround, TheRobotsCovarianceGoesOnFromTheGroundThatItLeaves) {
  const Patrol ring;
  const auto lap = static_cast<std::size_t>(ring.places);
  const auto drive = patrol(ring, 5);
  ExperienceMap patrolled{ExperienceMapParams{}};
  go(patrolled, drive, 0, 2 * lap);
  for (std::size_t left = 2 * lap; left < drive.size(); ++left) {
    go(patrolled, drive, left, left + 1);
    State state;
    patrolled.save(state);
    ExperienceMap map{ExperienceMapParams{}};
    map.load(state);
    OdometryStep step;
    step.forward = ring.spacing;
    step.rotation = -0.5 * kPi;
    Stamp now = drive[left].end;
    for (std::uint32_t k = 0; k < 5; ++k, step.rotation = 0.0) {
      map.integrate(now += 400'000'000, step);
      const auto id = static_cast<std::uint32_t>(map.graph().experiences().size());
      map.apply({now, ActionKind::kCreateNode, *map.currentExperience(), id, 0.0, {}});
    }
    for (int k = 0; k < 300; ++k) map.integrate(++now, OdometryStep{});  // the solver finishes
    const double online = map.robotCovariance()->trace();
    map.settle();
    const double settled = map.robotCovariance()->trace();
    EXPECT_GT(online, 0.999 * settled) << "left after step " << left;
  }
}

/// At a hundred steps a second for a day, standing still, the path costs nothing; what was driven before and after
/// keeps its shape.
TEST(Trajectory, StandingStillCostsNothing) {
  ExperienceMapParams params;
  params.exp_trajectory_poses = 2000;
  ExperienceMap map(params);
  const int day = 24 * 3600 * 10;  // ten steps a second: the count of poses does not depend on it
  const auto moves = [](int k) { return k < 500 || k > day - 500; };
  map.start(0);
  OdometryStep step;
  for (int k = 1; k <= day; ++k) {
    step.forward = moves(k) ? 0.1 : 0.0;
    step.rotation = moves(k) ? 0.01 : 0.0;
    map.integrate(k * 100'000'000LL, step);
    if (k == 1) map.apply({k * 100'000'000LL, ActionKind::kCreateNode, 0, 0, 0.0, {}});
  }
  const auto path = map.finalTrajectory();
  ASSERT_LE(path.size(), 2001U);
  // Ten metres and half of a turn each way: the poses that are left lie on the arc, and the path between them.
  MapPose pose;
  pose.yaw = kPi / 2.0;
  std::size_t next = 0;
  for (int k = 1; k <= day; ++k) {
    step.forward = moves(k) ? 0.1 : 0.0;
    step.rotation = moves(k) ? 0.01 : 0.0;
    pose = compose(pose, {step.forward * std::cos(step.rotation), step.forward * std::sin(step.rotation), 0.0,
                          step.rotation});
    while (next + 1 < path.size() && path[next + 1].stamp < k * 100'000'000LL) ++next;
    if (next + 1 >= path.size()) continue;
    const StampedPose& a = path[next];
    const StampedPose& b = path[next + 1];
    const double share = secondsBetween(a.stamp, k * 100'000'000LL) / secondsBetween(a.stamp, b.stamp);
    ASSERT_NEAR(a.pose.x + share * (b.pose.x - a.pose.x), pose.x, 0.02) << "at step " << k;
    ASSERT_NEAR(a.pose.y + share * (b.pose.y - a.pose.y), pose.y, 0.02) << "at step " << k;
  }
}

TEST(UncertainPose, JoiningAndInvertingAreThoseOfPoses) {
  const UncertainPose a{{1.0, 2.0, 0.5, 0.7}, Eigen::Vector4d(0.1, 0.2, 0.3, 0.01).asDiagonal()};
  const UncertainPose back = joined(a, inverted(a));
  EXPECT_NEAR(std::hypot(back.pose.x, back.pose.y, back.pose.z), 0.0, 1e-12);
  EXPECT_NEAR(back.pose.yaw, 0.0, 1e-12);
  const UncertainPose twice = inverted(inverted(a));
  EXPECT_NEAR((twice.covariance - a.covariance).norm(), 0.0, 1e-12);
  const UncertainPose both = combined(a, a);
  EXPECT_NEAR((both.covariance - 0.5 * a.covariance).norm(), 0.0, 1e-12);
  EXPECT_NEAR(both.pose.x, a.pose.x, 1e-12);
}

}  // namespace
}  // namespace ratslam
