#include "ratslam/vision/window_adjustment.h"

#include <algorithm>

#include "ratslam/vision/bundle_adjustment.h"

namespace ratslam {
namespace {

constexpr int kStrikesAllowed = 1;

/// The bundle problem of a window, and the origin of its parts in the map.
struct Window {
  BundleProblem problem;
  std::vector<KeyframeId> keyframe_of_pose;
  std::vector<std::size_t> landmark_of_point;
  std::vector<LandmarkObservation*> observation;  // one per bundle observation
};

Window makeWindow(LocalMap& map, const WindowParams& params, double sigma) {
  Window window;
  const auto& keyframes = map.keyframes();
  const int count = static_cast<int>(keyframes.size());
  const int free = std::min(params.free_keyframes, count - 1);
  const KeyframeId first = keyframes.front().id;
  const KeyframeId first_free = first + count - free;

  const auto seen_by_free = [&](const Landmark& landmark) {
    return landmark.observations.size() >= 2 && landmark.observations.back().keyframe >= first_free;
  };
  // Fixed are the older keyframes that share most landmarks with the window; of equals the newer one.
  std::vector<int> shared(static_cast<std::size_t>(count - free), 0);
  for (const Landmark& landmark : map.landmarks()) {
    if (!seen_by_free(landmark)) continue;
    for (const LandmarkObservation& observation : landmark.observations) {
      if (observation.keyframe < first_free) ++shared[static_cast<std::size_t>(observation.keyframe - first)];
    }
  }
  std::vector<int> order;
  for (int i = count - free - 1; i >= 0; --i) {
    if (shared[static_cast<std::size_t>(i)] > 0) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return shared[static_cast<std::size_t>(a)] > shared[static_cast<std::size_t>(b)];
  });
  order.resize(std::min(order.size(), static_cast<std::size_t>(params.fixed_keyframes)));

  std::vector<int> pose_of(static_cast<std::size_t>(count), -1);
  const auto add_pose = [&](int keyframe) {
    pose_of[static_cast<std::size_t>(keyframe)] = static_cast<int>(window.problem.poses.size());
    window.keyframe_of_pose.push_back(first + keyframe);
    window.problem.poses.push_back(keyframes[static_cast<std::size_t>(keyframe)].frame->T_camera_world);
  };
  for (int i = count - free; i < count; ++i) add_pose(i);
  window.problem.free_poses = free;
  for (const int i : order) add_pose(i);

  for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
    Landmark& landmark = map.landmarks()[i];
    if (!seen_by_free(landmark)) continue;
    const int point = static_cast<int>(window.problem.points.size());
    const std::size_t before = window.problem.observations.size();
    for (LandmarkObservation& observation : landmark.observations) {
      const int pose = pose_of[static_cast<std::size_t>(observation.keyframe - first)];
      if (pose < 0) continue;
      window.problem.observations.push_back({pose, point, observation.pixel, observation.sigma * sigma});
      window.observation.push_back(&observation);
    }
    if (window.problem.observations.size() - before < 2) {
      window.problem.observations.resize(before);
      window.observation.resize(before);
      continue;
    }
    window.problem.points.push_back(landmark.position);
    window.landmark_of_point.push_back(i);
  }
  return window;
}

/// Length of each error / relative standard deviation of the observation [px]; negative behind a camera.
std::vector<double> relativeErrors(const CameraModel& camera, const Window& window) {
  std::vector<double> errors;
  errors.reserve(window.observation.size());
  for (std::size_t i = 0; i < window.observation.size(); ++i) {
    const BundleObservation& observation = window.problem.observations[i];
    const Eigen::Vector3d x = window.problem.poses[static_cast<std::size_t>(observation.pose)] *
                              window.problem.points[static_cast<std::size_t>(observation.point)];
    const Reprojection reprojection = reproject(camera, x, observation.pixel);
    errors.push_back(reprojection.depth > 0.0 ? reprojection.error.norm() / window.observation[i]->sigma
                                              : -1.0);
  }
  return errors;
}

double sigmaOf(const std::vector<double>& errors, const RobustLoss& loss) {
  std::vector<double> in_front;
  std::copy_if(errors.begin(), errors.end(), std::back_inserter(in_front), [](double e) { return e >= 0.0; });
  return std::max(loss.min_sigma, robustSigma(std::move(in_front)));
}

}  // namespace

WindowSummary adjustWindow(const CameraModel& camera, LocalMap& map, const WindowParams& params,
                           const RobustLoss& loss) {
  WindowSummary summary;
  if (map.keyframes().size() < 2) return summary;
  Window window = makeWindow(map, params, 1.0);
  const double sigma_before = sigmaOf(relativeErrors(camera, window), loss);
  for (BundleObservation& observation : window.problem.observations) observation.sigma *= sigma_before;

  BundleOptions options;
  options.max_iterations = params.max_iterations;
  options.huber = loss.huber;
  adjustBundle(camera, window.problem, options);

  for (int pose = 0; pose < window.problem.free_poses; ++pose) {
    const auto i = static_cast<std::size_t>(pose);
    map.keyframe(window.keyframe_of_pose[i])->frame->T_camera_world = window.problem.poses[i];
  }
  for (std::size_t point = 0; point < window.landmark_of_point.size(); ++point) {
    map.landmarks()[window.landmark_of_point[point]].position = window.problem.points[point];
  }

  const std::vector<double> errors = relativeErrors(camera, window);
  summary.sigma = sigmaOf(errors, loss);
  summary.observations = static_cast<int>(errors.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double normalised = errors[i] / summary.sigma;
    const bool wrong = errors[i] < 0.0 || normalised * normalised > loss.gate;
    window.observation[i]->strikes = wrong ? window.observation[i]->strikes + 1 : 0;
  }
  for (const std::size_t i : window.landmark_of_point) {
    auto& observations = map.landmarks()[i].observations;
    const auto kept = std::remove_if(observations.begin(), observations.end(),
                                     [](const auto& o) { return o.strikes > kStrikesAllowed; });
    summary.removed += static_cast<int>(observations.end() - kept);
    observations.erase(kept, observations.end());
  }
  return summary;
}

}  // namespace ratslam
