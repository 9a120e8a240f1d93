#include "ratslam/odometry/orb/frame_tracker.h"

#include <algorithm>
#include <array>
#include <optional>

#include "ratslam/vision/matching.h"

namespace ratslam {
namespace {

constexpr std::array<double, 3> kSearchRadii = {12.0, 30.0, 70.0};  // around the predicted position [px]
constexpr double kFallbackRadius =
    6.0;                            // of the descriptor search if alignment from the projection fails [px]
constexpr std::size_t kShare = 64;  // landmarks that one worker takes at a time
constexpr double kLenientCorrelation = 0.7;  // of patches, if tracking fails otherwise
constexpr int kEnoughForPose = 40;           // with so many inliers no wider search is needed
// Chance matches lie anywhere in the window: their errors have a deviation of 0.6 of its radius, and all of them fit
// a pose with such errors.
constexpr double kMostSpread = 0.25;  // largest standard deviation of the errors / search radius
constexpr double kMostSigma = 1.5;    // of aligned patches [px]

/// Pose from descriptor matches of the last frame's landmarks.
PoseEstimate poseFromLastFrame(const CameraModel& camera, const LocalMap& map,
                               const std::vector<Observation>& last, const RigidTransform& predicted,
                               const Frame& frame, const RobustLoss& loss) {
  PoseEstimate best;
  for (const double radius : kSearchRadii) {
    DescriptorSearch search;
    search.radius = radius;
    std::vector<PoseObservation> matches;
    for (const Observation& observation : last) {
      const Landmark* landmark = map.landmark(observation.landmark);
      if (!landmark) continue;
      const auto index = static_cast<std::size_t>(landmark - map.landmarks().data());
      const auto projected = projectLandmark(camera, map, index, predicted);
      if (!projected) continue;
      const int found =
          searchNear(frame, landmark->descriptor.data(), projected->pixel, projected->scale, search);
      if (found < 0) continue;
      const Feature& feature = frame.features[static_cast<std::size_t>(found)];
      matches.push_back({landmark->position, feature.pixel, frame.pyramid.scale(feature.level)});
    }
    PoseEstimate estimate = refinePose(camera, predicted, matches, loss);
    if (estimate.sigma > kMostSpread * radius) continue;
    if (estimate.inliers > best.inliers) best = std::move(estimate);
    if (best.inliers >= kEnoughForPose && 2 * best.inliers > static_cast<int>(matches.size())) break;
  }
  return best;
}

/// Observation of a landmark in a frame, if any.
struct Sighting {
  bool in_view = false;
  std::optional<Observation> observation;
};

Sighting findLandmark(const CameraModel& camera, const LocalMap& map, std::size_t index,
                      const RigidTransform& pose, const Frame& frame, const AlignmentLimits& limits) {
  Sighting sighting;
  const auto projected = projectLandmark(camera, map, index, pose);
  if (!projected) return sighting;
  sighting.in_view = true;
  sighting.observation = alignLandmark(camera, map, *projected, frame, projected->pixel, limits);
  if (sighting.observation) return sighting;
  DescriptorSearch search;
  search.radius = kFallbackRadius;
  const int found =
      searchNear(frame, map.landmarks()[index].descriptor.data(), projected->pixel, projected->scale, search);
  if (found < 0) return sighting;
  const Eigen::Vector2d start = frame.features[static_cast<std::size_t>(found)].pixel;
  sighting.observation = alignLandmark(camera, map, *projected, frame, start, limits);
  return sighting;
}

}  // namespace

TrackingOutcome trackFrame(const CameraModel& camera, LocalMap& map, const std::vector<Observation>& last,
                           const RigidTransform& predicted, Frame& frame, const TrackingParams& params,
                           WorkerPool& workers) {
  const PoseEstimate rough = poseFromLastFrame(camera, map, last, predicted, frame, params.loss);
  const bool rough_is_good = rough.inliers >= params.min_tracked / 2;
  if (rough_is_good) {
    TrackingOutcome outcome = trackLocalMap(camera, map, rough.T_camera_world, frame, params, workers);
    if (outcome.tracked) return outcome;
  }
  // After blank frames the descriptors may fail while the prediction is still right to a few pixels.
  TrackingOutcome outcome = trackLocalMap(camera, map, predicted, frame, params, workers);
  if (outcome.tracked) return outcome;
  // The camera may have come so much nearer that patches have changed.
  TrackingParams lenient = params;
  lenient.alignment.min_correlation = kLenientCorrelation;
  return trackLocalMap(camera, map, rough_is_good ? rough.T_camera_world : predicted, frame, lenient,
                       workers);
}

TrackingOutcome trackLocalMap(const CameraModel& camera, LocalMap& map, const RigidTransform& pose,
                              Frame& frame, const TrackingParams& params, WorkerPool& workers) {
  const std::size_t landmarks = map.landmarks().size();
  std::vector<Sighting> sightings(landmarks);
  const std::size_t shares = (landmarks + kShare - 1) / kShare;
  workers.run(static_cast<int>(shares), [&](int share) {
    const std::size_t begin = static_cast<std::size_t>(share) * kShare;
    for (std::size_t i = begin; i < std::min(landmarks, begin + kShare); ++i) {
      sightings[i] = findLandmark(camera, map, i, pose, frame, params.alignment);
    }
  });

  TrackingOutcome outcome;
  std::vector<Observation> observations;
  std::vector<PoseObservation> matches;
  std::vector<std::size_t> in_view;
  for (std::size_t i = 0; i < landmarks; ++i) {
    if (sightings[i].in_view) in_view.push_back(i);
    const auto& observation = sightings[i].observation;
    if (!observation) continue;
    observations.push_back(*observation);
    matches.push_back({map.landmarks()[i].position, observation->pixel, observation->sigma});
  }
  outcome.in_view = static_cast<int>(in_view.size());
  outcome.estimate = refinePose(camera, pose, matches, params.loss);
  if (outcome.estimate.inliers < params.min_tracked || outcome.estimate.sigma > kMostSigma) return outcome;

  outcome.tracked = true;
  frame.T_camera_world = outcome.estimate.T_camera_world;
  frame.observations.clear();
  for (const std::size_t index : in_view) ++map.landmarks()[index].visible;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!outcome.estimate.inlier[i]) continue;
    frame.observations.push_back(observations[i]);
    ++map.landmark(observations[i].landmark)->found;
  }
  return outcome;
}

}  // namespace ratslam
