#include "ratslam/vision/matching.h"

#include <Eigen/LU>
#include <cmath>

namespace ratslam {
namespace {

constexpr double kMargin = 8.0;             // from the image's edge [px]
constexpr double kMostMagnification = 5.0;  // from the reference view to the present one
constexpr double kLevelTolerance = 1.5;  // ratio of a feature's scale to the predicted one: two levels of 1.2

const FeatureKernels& kernels = featureKernels();

/// The most similar of the descriptors that were shown one after the other. What is farther than the most distance
/// counts as a rival just beyond it, so that a lone match must be as distinct as any other.
class MostSimilar {
 public:
  explicit MostSimilar(int most_distance) : least_(most_distance + 1) {}
  void show(int distance, int index) {
    if (distance < least_) {
      second_ = least_;
      least_ = distance;
      index_ = index;
    } else if (distance < second_) {
      second_ = distance;
    }
  }
  /// Its index; -1 if none is similar enough, or the second one is about as similar.
  int index(double most_ratio) const { return index_ >= 0 && least_ <= most_ratio * second_ ? index_ : -1; }

 private:
  int least_;
  int second_ = 256;  // [bits] all of a descriptor
  int index_ = -1;
};

}  // namespace

int hammingDistance(const std::uint8_t* a, const std::uint8_t* b) { return kernels.hammingDistance(a, b); }

std::vector<std::pair<std::size_t, std::size_t>> mutuallyMostSimilar(const cv::Mat& first,
                                                                     const cv::Mat& second, int most_distance,
                                                                     double most_ratio) {
  std::vector<MostSimilar> forth(static_cast<std::size_t>(first.rows), MostSimilar(most_distance));
  std::vector<MostSimilar> back(static_cast<std::size_t>(second.rows), MostSimilar(most_distance));
  std::vector<int> distances(back.size());
  // Each distance is computed once and serves both directions.
  for (int i = 0; i < first.rows; ++i) {
    kernels.hammingDistances(first.ptr(i), second.ptr(), distances.size(), distances.data());
    for (std::size_t k = 0; k < distances.size(); ++k) {
      forth[static_cast<std::size_t>(i)].show(distances[k], static_cast<int>(k));
      back[k].show(distances[k], i);
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (int i = 0; i < first.rows; ++i) {
    const int there = forth[static_cast<std::size_t>(i)].index(most_ratio);
    if (there < 0 || back[static_cast<std::size_t>(there)].index(most_ratio) != i) continue;
    pairs.emplace_back(i, there);
  }
  return pairs;
}

Eigen::Matrix2d predictWarp(const CameraModel& camera, const Eigen::Vector2d& pixel, double depth,
                            const RigidTransform& T_target_source) {
  const Eigen::Vector3d x = T_target_source * (depth * camera.bearing(pixel));
  const double inverse = 1.0 / x.z();
  Eigen::Matrix<double, 2, 3> projection;
  projection << camera.fx * inverse, 0.0, -camera.fx * x.x() * inverse * inverse,  //
      0.0, camera.fy * inverse, -camera.fy * x.y() * inverse * inverse;
  const Eigen::Matrix3d rotation = T_target_source.rotation.toRotationMatrix();
  Eigen::Matrix2d warp = projection * rotation.leftCols<2>() * depth;
  warp.col(0) /= camera.fx;
  warp.col(1) /= camera.fy;
  return warp;
}

std::optional<ProjectedLandmark> projectLandmark(const CameraModel& camera, const LocalMap& map,
                                                 std::size_t index, const RigidTransform& T_camera_world) {
  const Landmark& landmark = map.landmarks()[index];
  const Eigen::Vector3d x = T_camera_world * landmark.position;
  if (!(x.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d pixel = camera.project(x);
  const Eigen::Vector2d raw = camera.distort(pixel);
  if (!(raw.x() >= kMargin) || !(raw.y() >= kMargin) || !(raw.x() < camera.width - kMargin) ||
      !(raw.y() < camera.height - kMargin)) {
    return std::nullopt;
  }
  const Frame& reference = *map.keyframe(landmark.reference)->frame;
  const Eigen::Vector3d x_reference = reference.T_camera_world * landmark.position;
  if (!(x_reference.z() > 0.0)) return std::nullopt;

  ProjectedLandmark projected;
  projected.index = index;
  projected.pixel = pixel;
  projected.warp = predictWarp(camera, camera.project(x_reference), x_reference.z(),
                               T_camera_world * reference.T_camera_world.inverse());
  const double determinant = projected.warp.determinant();
  if (!(determinant > 1.0 / (kMostMagnification * kMostMagnification)) ||
      !(determinant < kMostMagnification * kMostMagnification)) {
    return std::nullopt;
  }
  projected.scale = reference.pyramid.scale(landmark.reference_level) * std::sqrt(determinant);
  return projected;
}

int searchNear(const Frame& frame, const std::uint8_t* descriptor, const Eigen::Vector2d& pixel, double scale,
               const DescriptorSearch& search) {
  const double radius = search.radius * scale;
  int best = search.max_distance + 1;
  int second = 256;
  int best_feature = -1;
  Eigen::Vector2d best_pixel = Eigen::Vector2d::Zero();
  frame.grid.forEachNear(pixel, radius, [&](const PointGrid::Point& point) {
    if ((point.pixel - pixel).squaredNorm() > radius * radius) return;
    const double level_scale = frame.pyramid.scale(point.level);
    if (level_scale > kLevelTolerance * scale || scale > kLevelTolerance * level_scale) return;
    const int distance = hammingDistance(descriptor, frame.descriptor(point.feature));
    // The same corner at the next level does not count as second best.
    const bool rival = best_feature >= 0 && (best_pixel - point.pixel).squaredNorm() > 9.0 * scale * scale;
    if (distance < best) {
      if (rival) second = best;
      best = distance;
      best_feature = point.feature;
      best_pixel = point.pixel;
    } else if (distance < second && (rival || best_feature < 0)) {
      second = distance;
    }
  });
  if (best_feature < 0 || best > search.max_ratio * second) return -1;
  return best_feature;
}

std::optional<Observation> alignLandmark(const CameraModel& camera, const LocalMap& map,
                                         const ProjectedLandmark& projected, const Frame& frame,
                                         const Eigen::Vector2d& start, const AlignmentLimits& limits) {
  const Landmark& landmark = map.landmarks()[projected.index];
  const Frame& reference = *map.keyframe(landmark.reference)->frame;
  const DistortedPixel raw_start = camera.distortWithJacobian(start);
  Eigen::Matrix2d warp = projected.warp;
  if (camera.model != LensModel::kNone) {
    const Eigen::Vector2d reference_pixel = camera.project(reference.T_camera_world * landmark.position);
    warp = raw_start.jacobian * warp * camera.distortWithJacobian(reference_pixel).jacobian.inverse();
  }
  const PatchSource source{&reference.pyramid, landmark.reference_raw, landmark.reference_level};
  const auto match = alignPatch(source, frame.pyramid, raw_start.raw, warp, limits);
  if (!match) return std::nullopt;
  return Observation{landmark.id, camera.undistort(match->raw), frame.pyramid.scale(match->level),
                     match->level};
}

}  // namespace ratslam
