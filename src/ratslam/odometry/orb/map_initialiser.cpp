#include "ratslam/odometry/orb/map_initialiser.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ratslam/common/angles.h"
#include "ratslam/vision/matching.h"
#include "ratslam/vision/window_adjustment.h"

namespace ratslam {
namespace {

constexpr double kSearchRadius = 90.0;  // largest motion of a point while a map starts [px]
constexpr int kAdjustmentRounds = 20;
constexpr double kTurnDeg = 0.3;  // standard deviation of the turn between a map's first frames

/// The pixel after a pure rotation; none if it leaves the image plane.
std::optional<Eigen::Vector2d> turned(const CameraModel& camera, const Eigen::Quaterniond& rotation,
                                      const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d bearing = rotation * camera.bearing(pixel);
  if (bearing.z() <= 0.0) return std::nullopt;
  return camera.project(bearing);
}

/// Mutually best matches between the features of the reference and a frame.
/// @param back_turn from the axes of the frame to those of the reference.
std::vector<std::pair<int, int>> matchFeatures(const CameraModel& camera, const Frame& reference,
                                               const Frame& frame, const Eigen::Quaterniond& back_turn) {
  DescriptorSearch search;
  search.radius = kSearchRadius;
  search.max_distance = 50;
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < static_cast<int>(reference.features.size()); ++i) {
    const Feature& feature = reference.features[static_cast<std::size_t>(i)];
    if (feature.level > 3) continue;  // higher levels have few and coarse features
    const double scale = reference.pyramid.scale(feature.level);
    const auto near = turned(camera, back_turn.conjugate(), feature.pixel);
    if (!near) continue;
    const int there = searchNear(frame, reference.descriptor(i), *near, scale, search);
    if (there < 0) continue;
    const Feature& found = frame.features[static_cast<std::size_t>(there)];
    const auto near_before = turned(camera, back_turn, found.pixel);
    if (!near_before) continue;
    const int back = searchNear(reference, frame.descriptor(there), *near_before,
                                frame.pyramid.scale(found.level), search);
    if (back == i) pairs.emplace_back(i, there);
  }
  return pairs;
}

}  // namespace

std::optional<InitialMap> MapInitialiser::add(const std::shared_ptr<Frame>& frame,
                                              const std::optional<UncertainTurn>& turn) {
  if (!reference_) {
    reference_ = frame;
    return std::nullopt;
  }
  std::vector<std::pair<int, int>> pairs =
      matchFeatures(camera_, *reference_, *frame, turn ? turn->rotation : Eigen::Quaterniond::Identity());
  if (static_cast<int>(pairs.size()) < params_.min_points) {
    resume(frame, {false, progress_.lost_reference || progress_.short_of_parallax});
    return std::nullopt;
  }
  // Align the matches. Those that cannot be aligned are left out, because the first map cannot check them.
  std::vector<Eigen::Vector2d> first;
  std::vector<Eigen::Vector2d> second;
  std::size_t kept = 0;
  for (const auto& [here, there] : pairs) {
    const Feature& source = reference_->features[static_cast<std::size_t>(here)];
    const Feature& target = frame->features[static_cast<std::size_t>(there)];
    const double magnification = frame->pyramid.scale(target.level) / reference_->pyramid.scale(source.level);
    const auto match = alignPatch({&reference_->pyramid, source.raw, source.level}, frame->pyramid,
                                  target.raw, magnification * Eigen::Matrix2d::Identity(), AlignmentLimits{});
    if (!match) continue;
    pairs[kept++] = {here, there};
    first.push_back(source.pixel);
    second.push_back(camera_.undistort(match->raw));
  }
  pairs.resize(kept);
  TwoViewParams any_parallax = params_;
  any_parallax.min_parallax_deg = 0.0;
  const auto motion = estimateTwoViewMotion(camera_, first, second, any_parallax);
  if (!motion) return std::nullopt;
  if (!hasParallax(*motion)) {
    progress_.short_of_parallax = true;
    return std::nullopt;
  }
  if (turn) {
    const double off =
        (turn->rotation * motion->T_second_first.rotation).angularDistance(Eigen::Quaterniond::Identity());
    const double sigma = std::hypot(degreesToRadians(kTurnDeg), std::sqrt(turn->covariance.trace()));
    if (off > 3.0 * sigma) return std::nullopt;
  }
  return makeMap(frame, pairs, second, *motion);
}

void MapInitialiser::resume(std::shared_ptr<Frame> reference, const Progress& progress) {
  reference_ = std::move(reference);
  progress_ = progress;
}

bool MapInitialiser::hasParallax(const TwoViewMotion& motion) const {
  const double times_the_points = static_cast<double>(motion.triangulated) / std::max(params_.min_points, 1);
  const double counted = progress_.lost_reference ? std::sqrt(times_the_points) : 1.0;
  return counted * motion.parallax_deg >= params_.min_parallax_deg;
}

std::optional<InitialMap> MapInitialiser::makeMap(const std::shared_ptr<Frame>& frame,
                                                  const std::vector<std::pair<int, int>>& pairs,
                                                  const std::vector<Eigen::Vector2d>& second,
                                                  const TwoViewMotion& motion) const {
  InitialMap initial{reference_, frame, LocalMap(map_keyframes_)};
  Frame& reference = *initial.first;
  reference.T_camera_world = RigidTransform{};
  reference.observations.clear();
  frame->T_camera_world = motion.T_second_first;
  frame->observations.clear();
  const KeyframeId first_id = initial.map.addKeyframe(initial.first, camera_).id;
  std::vector<LandmarkObservation> later;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!motion.points[i]) continue;
    const Feature& feature = reference.features[static_cast<std::size_t>(pairs[i].first)];
    const double sigma = reference.pyramid.scale(feature.level);
    Landmark landmark;
    landmark.position = *motion.points[i];
    std::copy_n(reference.descriptor(pairs[i].first), landmark.descriptor.size(),
                landmark.descriptor.begin());
    landmark.reference = landmark.created = first_id;
    landmark.reference_raw = feature.raw;
    landmark.reference_level = feature.level;
    landmark.visible = landmark.found = 1;
    landmark.observations.push_back({first_id, feature.pixel, sigma, 0});
    const LandmarkId id = initial.map.addLandmark(std::move(landmark));
    reference.observations.push_back({id, feature.pixel, sigma, feature.level});
    frame->observations.push_back({id, second[i], sigma, feature.level});
  }
  initial.map.addKeyframe(frame, camera_);

  WindowParams window;
  window.free_keyframes = 1;
  window.max_iterations = kAdjustmentRounds;
  adjustWindow(camera_, initial.map, window, RobustLoss{});
  const double depth = initial.map.medianDepth(frame->T_camera_world);
  if (!(depth > 0.0) || !std::isfinite(depth)) return std::nullopt;
  initial.map.rescale(1.0 / depth, Eigen::Vector3d::Zero());
  return initial;
}

}  // namespace ratslam
