#include "ratslam/odometry/orb/relocalisation.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "ratslam/vision/matching.h"

namespace ratslam {
namespace {

constexpr int kMaxDistance = 50;  // [bits]
constexpr double kMaxRatio = 0.8;
constexpr int kIterations = 300;
constexpr float kReprojectionError = 4.0F;  // [px]
constexpr double kConfidence = 0.999;

/// Index of the feature most similar to a landmark in the whole frame, or -1.
int mostSimilar(const Frame& frame, const std::uint8_t* descriptor) {
  int best = kMaxDistance + 1;
  int second = 256;
  int feature = -1;
  for (int i = 0; i < static_cast<int>(frame.features.size()); ++i) {
    const int distance = hammingDistance(descriptor, frame.descriptor(i));
    if (distance < best) {
      second = best;
      best = distance;
      feature = i;
    } else if (distance < second) {
      second = distance;
    }
  }
  return feature >= 0 && best <= kMaxRatio * second ? feature : -1;
}

}  // namespace

TrackingOutcome relocalise(const CameraModel& camera, LocalMap& map, Frame& frame, int min_inliers,
                           const TrackingParams& params, WorkerPool& workers) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  std::vector<PoseObservation> matches;
  for (const Landmark& landmark : map.landmarks()) {
    const int found = mostSimilar(frame, landmark.descriptor.data());
    if (found < 0) continue;
    const Feature& feature = frame.features[static_cast<std::size_t>(found)];
    points.emplace_back(landmark.position.x(), landmark.position.y(), landmark.position.z());
    pixels.emplace_back(feature.pixel.x(), feature.pixel.y());
    matches.push_back({landmark.position, feature.pixel, frame.pyramid.scale(feature.level)});
  }
  if (static_cast<int>(matches.size()) < params.min_tracked) return {};
  cv::Mat k;
  const Eigen::Matrix3d camera_matrix = camera.matrix();
  cv::eigen2cv(camera_matrix, k);
  cv::Mat rotation_vector;
  cv::Mat translation;
  if (!cv::solvePnPRansac(points, pixels, k, cv::noArray(), rotation_vector, translation, false, kIterations,
                          kReprojectionError, kConfidence, cv::noArray(), cv::SOLVEPNP_AP3P)) {
    return {};
  }
  Eigen::Vector3d omega;
  RigidTransform pose;
  cv::cv2eigen(rotation_vector, omega);
  cv::cv2eigen(translation, pose.translation);
  pose.rotation = expRotation(omega);
  if (!omega.allFinite() || !pose.translation.allFinite()) return {};
  // OpenCV's inliers are those before its own refinement. So refine and count again.
  const PoseEstimate rough = refinePose(camera, pose, matches, params.loss);
  if (rough.inliers < params.min_tracked / 2) return {};
  TrackingParams strict = params;
  strict.min_tracked = min_inliers;
  return trackLocalMap(camera, map, rough.T_camera_world, frame, strict, workers);
}

}  // namespace ratslam
