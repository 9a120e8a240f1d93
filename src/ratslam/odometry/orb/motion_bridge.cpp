#include "ratslam/odometry/orb/motion_bridge.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr double kFarApart = 0.5;           // a longer time between two frames is a gap [s]
constexpr double kOneEnd = 4.0;             // variance of a random walk known at one end / known at both ends
constexpr std::ptrdiff_t kMostFrames = 40;  // bound on kept frames, because image pyramids are large
constexpr std::size_t kMostSamples = 4000;  // after minutes without a map every pose is a guess

/// Scales a motion's translation and its standard deviation by a factor.
UncertainMotion lengthened(UncertainMotion motion, double times) {
  Matrix6 scaling = Matrix6::Identity();
  scaling.topLeftCorner<3, 3>() *= times;
  motion.motion.translation *= times;
  motion.covariance = scaling * motion.covariance * scaling;
  return motion;
}

}  // namespace

UncertainMotion compose(const UncertainMotion& a, const UncertainMotion& b) {
  UncertainMotion both;
  both.motion = a.motion * b.motion;
  const Eigen::Matrix3d turn = a.motion.rotation.toRotationMatrix();
  Matrix6 by_a = Matrix6::Identity();
  by_a.topRightCorner<3, 3>() = -skew(turn * b.motion.translation);
  Matrix6 by_b = Matrix6::Zero();
  by_b.topLeftCorner<3, 3>() = by_b.bottomRightCorner<3, 3>() = turn;
  both.covariance = by_a * a.covariance * by_a.transpose() + by_b * b.covariance * by_b.transpose();
  return both;
}

UncertainMotion MotionBridge::predict(Stamp stamp, const MotionHistory& history) const {
  const double begin = way_.empty() ? 0.0 : lasts(way_.back().stamp);
  return history.predict(begin, lasts(stamp));
}

MotionBridge::Step MotionBridge::look(const CameraModel& camera, Stamp stamp, const Frame* frame,
                                      const MotionHistory& history, WorkerPool& workers) const {
  Step step;
  step.stamp = stamp;
  step.motion = predict(stamp, history);
  step.pose = lastPose() * step.motion.motion;
  if (!frame || !last_frame_) return step;
  const double since_frame = secondsBetween(last_frame_->stamp, stamp);
  UncertainMotion since = history.predict(0.0, since_frame);
  since.motion = last_frame_pose_.inverse() * step.pose;
  const auto view = compareFarFeatures(camera, *last_frame_, *frame, since, since_frame > kFarApart, workers);
  if (!view) return step;
  step.seen = view->motion;
  step.pose.rotation = (last_frame_pose_.rotation * view->motion.motion.rotation).normalized();
  step.motion.motion.rotation = (lastPose().rotation.conjugate() * step.pose.rotation).normalized();
  step.motion.covariance.bottomRightCorner<3, 3>() = view->motion.covariance.bottomRightCorner<3, 3>();
  // The turn is measured now, independently of the translation.
  step.motion.covariance.topRightCorner<3, 3>().setZero();
  step.motion.covariance.bottomLeftCorner<3, 3>().setZero();
  return step;
}

void MotionBridge::add(const Step& step, std::shared_ptr<const Frame> frame) {
  if (frame) {
    links_.push_back({lastFrameStamp(), step.stamp, step.seen});
    last_frame_ = frame;
    last_frame_pose_ = step.pose;
  }
  way_.push_back({step.stamp, step.pose, std::move(frame)});
  thinOutFrames();
  thinOutSamples();
}

std::optional<UncertainTurn> MotionBridge::turnSince(Stamp earlier, const Step& step) const {
  if (!step.seen || earlier > lastFrameStamp()) return std::nullopt;
  UncertainMotion motion;
  for (const Link& link : links_) {
    if (link.end <= earlier) continue;
    if (!link.seen || link.begin < earlier) return std::nullopt;
    motion = compose(motion, *link.seen);
  }
  motion = compose(motion, *step.seen);
  return UncertainTurn{motion.motion.rotation, motion.covariance.bottomRightCorner<3, 3>()};
}

MotionBridge::Blind MotionBridge::blindAround(std::size_t link, const Vector6& before,
                                              const Vector6& after) const {
  const auto rate = [&](const Link& seen) {
    return Eigen::Vector3d(logRotation(seen.seen->motion.rotation) / secondsBetween(seen.begin, seen.end));
  };
  std::size_t first = link;
  while (first > 0 && !links_[first - 1].seen) --first;
  std::size_t last = link;
  while (last + 1 < links_.size() && !links_[last + 1].seen) ++last;
  Blind blind;
  blind.begin = lasts(links_[first].begin);
  blind.end = lasts(links_[last].end);
  // Only the yaw rate continues: pitch and roll of a vehicle return.
  const auto turning = [](const Eigen::Vector3d& whole) { return Eigen::Vector3d(0.0, whole.y(), 0.0); };
  blind.rate_before = turning(first > 0 ? rate(links_[first - 1]) : Eigen::Vector3d(before.tail<3>()));
  blind.rate_after =
      turning(last + 1 < links_.size() ? rate(links_[last + 1]) : Eigen::Vector3d(after.tail<3>()));
  return blind;
}

RigidTransform MotionBridge::along(std::size_t link, const Vector6& before, const Vector6& after,
                                   double whole) const {
  const Link& here = links_[link];
  const double duration = secondsBetween(here.begin, here.end);
  const double middle = 0.5 * (lasts(here.begin) + lasts(here.end));
  const double share = whole > 0.0 ? std::min(1.0, middle / whole) : 1.0;
  Vector6 twist = (1.0 - share) * before + share * after;
  if (!here.seen) {
    const Blind blind = blindAround(link, before, after);
    const double part = (middle - blind.begin) / (blind.end - blind.begin);
    twist.tail<3>() = (1.0 - part) * blind.rate_before + part * blind.rate_after;
    return expTransform(twist * duration);
  }
  const RigidTransform& seen = here.seen->motion;
  if (duration > kFarApart) return {seen.rotation, twist.head<3>().norm() * duration * seen.translation};
  twist.tail<3>() = logRotation(seen.rotation) / duration;
  return expTransform(twist * duration);
}

Matrix6 MotionBridge::covarianceAlong(std::size_t link, const RigidTransform& motion, const Vector6& before,
                                      const Vector6& after, bool known_before) const {
  const Link& here = links_[link];
  const double duration = secondsBetween(here.begin, here.end);
  if (!here.seen) {
    const Blind blind = blindAround(link, before, after);
    const double run = blind.end - blind.begin;
    double variance = MotionHistory::turnVariance(blind.rate_before, blind.rate_after, run) * duration / run;
    if (!known_before && blind.begin <= 0.0) variance *= kOneEnd;
    return MotionHistory::spread(motion.translation, 0.0, variance);
  }
  if (duration <= kFarApart) {
    Matrix6 covariance = MotionHistory::spread(motion.translation, 0.0, 0.0);
    covariance.bottomRightCorner<3, 3>() = here.seen->covariance.bottomRightCorner<3, 3>();
    return covariance;
  }
  return lengthened(*here.seen, motion.translation.norm()).covariance;
}

UncertainMotion MotionBridge::motionTo(const CameraModel& camera, const Frame& frame, const Vector6& after,
                                       const MotionHistory& history, WorkerPool& workers) const {
  const double whole = lasts(frame.stamp);
  if (whole <= 0.0) return {};
  const Vector6 before = history.empty() ? after : history.twist();
  UncertainMotion motion;
  std::size_t count = 0;
  for (; count < links_.size() && links_[count].end <= frame.stamp; ++count) {
    const RigidTransform link = along(count, before, after, whole);
    motion = compose(motion, {link, covarianceAlong(count, link, before, after, !history.empty())});
  }
  if (count < links_.size() && links_[count].begin < frame.stamp) {  // a joined link that contains the frame
    const Link& over = links_[count];
    const double share = secondsBetween(over.begin, frame.stamp) / secondsBetween(over.begin, over.end);
    const RigidTransform link = along(count, before, after, whole);
    motion = compose(motion, {expTransform(share * logTransform(link)),
                              covarianceAlong(count, link, before, after, !history.empty())});
  }
  // The error of the speed has the same sign all along the stretch.
  double variance = history.speedDiffusion() * std::pow(whole, 3) / 12.0;
  if (history.empty()) variance *= kOneEnd;
  const double length = motion.motion.translation.norm();
  const auto addLengthways = [&](UncertainMotion& to) {
    const Eigen::Vector3d ahead =
        length > 0.0 ? Eigen::Vector3d(to.motion.translation.normalized()) : Eigen::Vector3d::UnitZ();
    to.covariance.topLeftCorner<3, 3>() += variance * ahead * ahead.transpose();
  };
  UncertainMotion result = motion;
  addLengthways(result);
  // A direct comparison of both ends may be better than the chain of many frames.
  const bool compared = count == 1 && links_.front().seen;
  if (!before_ || compared || !(length > 0.0)) return result;
  const auto view = compareFarFeatures(camera, *before_, frame, result, true, workers);
  if (!view || view->motion.covariance.bottomRightCorner<3, 3>().trace() >
                   result.covariance.bottomRightCorner<3, 3>().trace())
    return result;
  UncertainMotion seen = lengthened(view->motion, length);
  addLengthways(seen);
  return seen;
}

std::vector<std::shared_ptr<const Frame>> MotionBridge::frames() const {
  std::vector<std::shared_ptr<const Frame>> frames;
  if (before_) frames.push_back(before_);
  for (const Sample& sample : way_) {
    if (sample.frame) frames.push_back(sample.frame);
  }
  return frames;
}

void MotionBridge::thinOutFrames() {
  const auto kept = [](const Sample& sample) { return sample.frame != nullptr; };
  if (std::count_if(way_.begin(), way_.end(), kept) <= kMostFrames) return;
  bool drop = false;
  for (Sample& sample : way_) {
    if (!sample.frame) continue;
    if (drop) sample.frame.reset();
    drop = !drop;
  }
}

void MotionBridge::thinOutSamples() {
  if (way_.size() > kMostSamples) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < way_.size(); ++k) {
      if (k % 2 == 1 || k > way_.size() / 2 || way_[k].frame) way_[kept++] = way_[k];
    }
    way_.resize(kept);
  }
  if (links_.size() > kMostSamples) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < links_.size(); ++k) {
      const bool join = k + 1 < links_.size() / 2;
      links_[kept++] = join ? joined(links_[k], links_[k + 1]) : links_[k];
      k += join ? 1 : 0;
    }
    links_.resize(kept);
  }
}

/// Joins two links. The result has far features only if both have.
MotionBridge::Link MotionBridge::joined(const Link& first, const Link& second) {
  Link both{first.begin, second.end, std::nullopt};
  if (!first.seen || !second.seen) return both;
  // At constant speed, scaled so that the whole translation has length 1 again.
  const double whole = secondsBetween(both.begin, both.end);
  const auto part = [whole](const Link& link) {
    return lengthened(*link.seen, secondsBetween(link.begin, link.end) / whole);
  };
  const UncertainMotion way = compose(part(first), part(second));
  const double length = way.motion.translation.norm();
  if (length > 0.0) both.seen = lengthened(way, 1.0 / length);
  return both;
}

std::vector<StampedPoseOfCamera> MotionBridge::layOut(const std::vector<StampedPoseOfCamera>& known,
                                                      const Vector6& before, const Vector6& after) const {
  // The path by the chain of frames, relative to the start.
  const double whole = lasts(known.back().stamp);
  std::vector<StampedPoseOfCamera> nodes{{from_.stamp, RigidTransform{}}};
  for (std::size_t i = 0; i < links_.size() && links_[i].end <= known.back().stamp; ++i)
    nodes.push_back({links_[i].end, nodes.back().pose * along(i, before, after, whole)});
  const auto course = [&](Stamp stamp) {
    const auto next = std::find_if(nodes.begin(), nodes.end(),
                                   [&](const StampedPoseOfCamera& node) { return node.stamp >= stamp; });
    if (next == nodes.end())
      return nodes.back().pose * expTransform(secondsBetween(nodes.back().stamp, stamp) * after);
    if (next == nodes.begin()) return next->pose;
    const StampedPoseOfCamera& last = *(next - 1);
    const double share = secondsBetween(last.stamp, stamp) / secondsBetween(last.stamp, next->stamp);
    return last.pose * expTransform(share * logTransform(last.pose.inverse() * next->pose));
  };
  std::vector<StampedPoseOfCamera> way;
  std::size_t sample = 0;
  StampedPoseOfCamera last{from_.stamp, RigidTransform{}};
  for (const StampedPoseOfCamera& place : known) {
    // The path by the chain from the last known pose to this one, deformed so that it ends there.
    const std::size_t first = way.size();
    const RigidTransform onto = last.pose * course(last.stamp).inverse();
    for (; sample < way_.size() && way_[sample].stamp < place.stamp; ++sample)
      way.push_back({way_[sample].stamp, onto * course(way_[sample].stamp)});
    const RigidTransform pose = onto * course(place.stamp);
    const Vector6 shift = logTransform(pose.inverse() * place.pose);
    const double duration = secondsBetween(last.stamp, place.stamp);
    for (std::size_t i = first; i < way.size(); ++i) {
      const double share = secondsBetween(last.stamp, way[i].stamp) / duration;
      way[i].pose = way[i].pose * expTransform(share * shift);
    }
    if (sample < way_.size() && way_[sample].stamp == place.stamp) ++sample;
    way.push_back(place);
    last = place;
  }
  way.pop_back();  // the end is not one of the samples in between
  return way;
}

}  // namespace ratslam
