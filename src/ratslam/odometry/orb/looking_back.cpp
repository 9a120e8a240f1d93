#include "ratslam/odometry/orb/looking_back.h"

#include <algorithm>
#include <cmath>

#include "ratslam/odometry/orb/relocalisation.h"

namespace ratslam {
namespace {

constexpr double kTrackedOver = 0.5;    // longest time over which frames are tracked and not searched [s]
constexpr double kMostRotation = 0.06;  // largest standard deviation with which patches are found [rad]
constexpr double kLenientCorrelation = 0.7;  // of patches seen from much farther away
constexpr double kWayStep = 0.05;            // relative step between the distances that are tried
constexpr double kMostWay = 0.4;             // largest relative change of the distance, to either side
constexpr int kSearches = 3;                 // failed searches after which older frames are skipped

enum class Search { kNever, kWhilePromising, kAlways };

/// Locates one frame after another, each from the pose of the one found before, the first one from a keyframe's.
class Trail {
 public:
  Trail(const CameraModel& camera, LocalMap& map, const Frame& keyframe, const Vector6& velocity,
        const LookingBackParams& params, WorkerPool& workers)
      : camera_(camera),
        map_(map),
        params_(params),
        workers_(workers),
        velocity_(velocity),
        pose_(keyframe.T_camera_world),
        stamp_(keyframe.stamp),
        last_(keyframe.observations) {}

  /// @return whether the frame was found
  bool follow(const Frame& original, Search search, std::vector<LocatedFrame>& located) {
    Frame frame = original;
    refreshFeatures(frame, camera_);
    const double dt = secondsBetween(stamp_, frame.stamp);
    TrackingOutcome outcome;
    if (std::abs(dt) < kTrackedOver) {
      const RigidTransform predicted = expTransform(velocity_ * dt) * pose_;
      outcome = trackFrame(camera_, map_, last_, predicted, frame, params_.tracking, workers_);
    }
    if (!outcome.tracked &&
        (search == Search::kAlways || (search == Search::kWhilePromising && searches_ < kSearches))) {
      outcome = relocalise(camera_, map_, frame, params_.search_inliers, params_.tracking, workers_);
      searches_ = outcome.tracked ? 0 : searches_ + 1;
    }
    if (!outcome.tracked) return false;
    velocity_ = logTransform(outcome.estimate.T_camera_world * pose_.inverse()) / dt;
    pose_ = outcome.estimate.T_camera_world;
    stamp_ = frame.stamp;
    last_ = std::move(frame.observations);
    located.push_back({stamp_, std::move(outcome.estimate)});
    return true;
  }

 private:
  const CameraModel& camera_;
  LocalMap& map_;
  const LookingBackParams& params_;
  WorkerPool& workers_;
  Vector6 velocity_;
  RigidTransform pose_;
  Stamp stamp_;
  std::vector<Observation> last_;
  int searches_ = 0;
};

}  // namespace

std::vector<LocatedFrame> lookBack(const CameraModel& camera, const LocalMap& map,
                                   std::vector<std::shared_ptr<const Frame>> frames, const Vector6& velocity,
                                   const LookingBackParams& params, WorkerPool& workers) {
  std::sort(frames.begin(), frames.end(), [](const auto& a, const auto& b) { return a->stamp < b->stamp; });
  LocalMap copy = map;  // sightings in old frames must not count in the statistics of the landmarks
  const Frame& first = *map.keyframes().front().frame;
  const auto later = std::find_if(frames.begin(), frames.end(),
                                  [&](const auto& frame) { return frame->stamp >= first.stamp; });
  std::vector<LocatedFrame> located;
  Trail back(camera, copy, first, velocity, params, workers);
  for (auto frame = later; frame != frames.begin();) {
    --frame;
    back.follow(**frame, frame == frames.begin() ? Search::kAlways : Search::kWhilePromising, located);
  }
  Trail forth(camera, copy, first, velocity, params, workers);
  auto next = later;
  while (next != frames.end() &&
         ((*next)->stamp == first.stamp || forth.follow(**next, Search::kNever, located))) {
    ++next;
  }
  // The rest, as after a halt without images, from the other side.
  const Frame& second = *map.keyframes()[1].frame;
  const Vector6 velocity_between = logTransform(second.T_camera_world * first.T_camera_world.inverse()) /
                                   secondsBetween(first.stamp, second.stamp);
  Trail from_second(camera, copy, second, velocity_between, params, workers);
  for (auto frame = frames.end(); frame != next;) {
    --frame;
    if ((*frame)->stamp < second.stamp) from_second.follow(**frame, Search::kNever, located);
  }
  std::sort(located.begin(), located.end(), [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  return located;
}

std::optional<PoseEstimate> findAlong(const CameraModel& camera, const LocalMap& map, const Frame& frame,
                                      const UncertainMotion& to_first, const LookingBackParams& params,
                                      WorkerPool& workers) {
  if (to_first.covariance.bottomRightCorner<3, 3>().trace() > kMostRotation * kMostRotation)
    return std::nullopt;
  const double way = to_first.motion.translation.norm();
  if (!(way > 0.0)) return std::nullopt;
  const Eigen::Vector3d direction = to_first.motion.translation / way;
  const double sigma = std::sqrt(direction.dot(to_first.covariance.topLeftCorner<3, 3>() * direction)) / way;
  LocalMap copy = map;
  TrackingParams lenient = params.tracking;
  lenient.min_tracked = params.search_inliers;
  lenient.alignment.min_correlation = kLenientCorrelation;
  std::optional<PoseEstimate> best;
  const double reach = std::clamp(3.0 * sigma, kWayStep, kMostWay);
  for (double share = -reach; share <= reach + 1e-9; share += kWayStep) {
    RigidTransform guess = to_first.motion;
    guess.translation *= std::max(0.1, 1.0 + share);
    Frame trial = frame;
    const TrackingOutcome outcome = trackLocalMap(
        camera, copy, guess * map.keyframes().front().frame->T_camera_world, trial, lenient, workers);
    if (outcome.tracked && (!best || outcome.estimate.inliers > best->inliers)) best = outcome.estimate;
  }
  return best;
}

}  // namespace ratslam
