#include "ratslam/vision/triangulation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "ratslam/common/angles.h"
#include "ratslam/vision/pose_refinement.h"

namespace ratslam {
namespace {

constexpr int kRefinementSteps = 5;
constexpr int kBatch = 512;               // features processed in parallel
constexpr int kShare = 32;                // features that one worker takes at a time
constexpr double kLeastBaseline = 0.005;  // to a neighbour / median depth
constexpr double kTakenRadius = 3.0;      // features nearer to an observation belong to its landmark [px]

/// Finds features of one frame on the epipolar lines of another's.
class EpipolarSearch {
 public:
  /// @param taken features of `to` that are excluded.
  EpipolarSearch(const CameraModel& camera, const Frame& from, const Frame& to,
                 const std::vector<bool>& taken, double max_error)
      : camera_(camera),
        from_(from),
        to_(to),
        grid_(to.grid.without(taken)),
        T_to_from_(to.T_camera_world * from.T_camera_world.inverse()),
        baseline_(T_to_from_.translation.norm()),
        max_error_(max_error) {
    for (int level = 0; level < from.pyramid.levels(); ++level) {
      std::pair<int, int> similar(to.pyramid.levels(), -1);
      for (int other = 0; other < to.pyramid.levels(); ++other) {
        const double zoom = to.pyramid.scale(other) / from.pyramid.scale(level);
        if (zoom > kMaxZoom || zoom < 1.0 / kMaxZoom) continue;
        similar = {std::min(similar.first, other), std::max(similar.second, other)};
      }
      levels_.push_back(similar);
    }
  }

  /// The best match of a feature, or -1.
  int find(int feature_index) const {
    const Feature& feature = from_.features[static_cast<std::size_t>(feature_index)];
    const Eigen::Vector3d ray = camera_.bearing(feature.pixel);
    const Eigen::Vector3d far = T_to_from_.rotation * ray;
    // The appearance of points nearer than about a baseline changes too much for a match.
    const Eigen::Vector3d near = T_to_from_ * (kNearest * baseline_ * ray);
    if (!(far.z() > kMinZ) || !(near.z() > kMinZ * baseline_)) return -1;
    const Eigen::Vector2d begin = camera_.project(far);
    const Eigen::Vector2d end = camera_.project(near);
    const double length = (end - begin).norm();
    if (!(length < kLongest)) return -1;
    const Eigen::Vector2d direction =
        length > 1e-9 ? Eigen::Vector2d((end - begin) / length) : Eigen::Vector2d(1, 0);
    const double scale = from_.pyramid.scale(feature.level);
    const double reach = max_error_ * scale;

    const std::pair<int, int> levels = levels_[static_cast<std::size_t>(feature.level)];

    Best best;
    grid_.forEachAlong(begin, end, reach, [&](const PointGrid::Point& point) {
      if (point.level < levels.first || point.level > levels.second) return;
      const Eigen::Vector2d offset = point.pixel - begin;
      const double along = direction.dot(offset);
      if (along <= -reach || along >= length + reach) return;
      if (std::abs(direction.x() * offset.y() - direction.y() * offset.x()) > reach) return;
      consider(feature_index, point, scale, best);
    });
    return best.feature >= 0 && best.distance <= kMaxRatio * best.second ? best.feature : -1;
  }

 private:
  static constexpr double kNearest = 1.5;    // baselines
  static constexpr double kMinZ = 0.05;      // z / distance; rays farther to the side leave any lens
  static constexpr double kLongest = 400.0;  // length of an epipolar segment [px]
  static constexpr int kMaxDistance = 60;    // [bits]
  static constexpr double kMaxRatio = 0.85;
  static constexpr float kMaxTurn = 30.0F;  // change of a feature's direction [deg]
  static constexpr double kMaxZoom = 1.8;   // factor of a feature's scale

  struct Best {
    int feature = -1;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    int distance = kMaxDistance + 1;
    int second = 256;
  };

  void consider(int feature_index, const PointGrid::Point& point, double scale, Best& best) const {
    const int distance = hammingDistance(from_.descriptor(feature_index), to_.descriptor(point.feature));
    if (distance >= best.second) return;
    const float turn = std::abs(from_.features[static_cast<std::size_t>(feature_index)].angle_deg -
                                to_.features[static_cast<std::size_t>(point.feature)].angle_deg);
    if (std::min(turn, 360.0F - turn) > kMaxTurn) return;
    const bool same_corner =
        best.feature >= 0 && (best.pixel - point.pixel).squaredNorm() < 9.0 * scale * scale;
    if (distance < best.distance) {
      if (!same_corner && best.feature >= 0) best.second = best.distance;
      best.distance = distance;
      best.feature = point.feature;
      best.pixel = point.pixel;
    } else if (!same_corner) {
      best.second = distance;
    }
  }

  const CameraModel& camera_;
  const Frame& from_;
  const Frame& to_;
  PointGrid grid_;
  RigidTransform T_to_from_;
  double baseline_;
  double max_error_;
  std::vector<std::pair<int, int>> levels_;  // for each level the first and the last one of possible matches
};

/// Marks the features that belong to a landmark or are too near to one.
std::vector<bool> explainedFeatures(const Frame& frame, double spacing) {
  std::vector<bool> explained(frame.features.size(), false);
  for (const Observation& observation : frame.observations) {
    const double radius = spacing * std::min(2.0, std::max(1.0, observation.sigma));
    frame.grid.forEachNear(observation.pixel, radius, [&](const PointGrid::Point& point) {
      if ((point.pixel - observation.pixel).squaredNorm() < radius * radius) {
        explained[static_cast<std::size_t>(point.feature)] = true;
      }
    });
  }
  return explained;
}

bool reprojectsWithin(const CameraModel& camera, const Eigen::Vector3d& point, const View& view,
                      double max_error) {
  const Reprojection reprojection = reproject(camera, view.T_camera_world * point, view.pixel);
  return reprojection.depth > 0.0 && reprojection.error.norm() <= max_error * view.sigma;
}

/// A feature of the newest keyframe that may become a landmark.
class Candidate {
 public:
  Candidate(const CameraModel& camera, const LocalMap& map, int feature)
      : camera_(camera), map_(map), newest_(*map.keyframes().back().frame), feature_(feature) {
    const Feature& source = newest_.features[static_cast<std::size_t>(feature)];
    views_.push_back({newest_.T_camera_world, source.pixel, newest_.pyramid.scale(source.level)});
    keyframes_.push_back(map.keyframes().back().id);
    pixel_by_raw_ = camera.distortWithJacobian(source.pixel).jacobian.inverse();
  }

  /// Takes a descriptor match as the second view and aligns it.
  bool start(const Keyframe& neighbour, int match, const TriangulationParams& params) {
    const Feature& target = neighbour.frame->features[static_cast<std::size_t>(match)];
    views_.resize(1);
    keyframes_.resize(1);
    views_.push_back(
        {neighbour.frame->T_camera_world, target.pixel, neighbour.frame->pyramid.scale(target.level)});
    // Most matches are too far away. The angle of their rays shows it before any triangulation.
    const double least_parallax = 0.5 * degreesToRadians(params.min_parallax_deg);
    if (rayOf(views_[0]).dot(rayOf(views_[1])) > std::cos(least_parallax)) return false;
    const auto rough = triangulate(camera_, views_);
    if (!rough || parallax(*rough, views_) < least_parallax) return false;
    point_ = *rough;
    views_.resize(1);
    return look(neighbour, target.pixel, 2.0 * params.max_epipolar_error);
  }

  /// Searches the patch in one more keyframe, around `expected`.
  bool look(const Keyframe& neighbour, const Eigen::Vector2d& expected, double max_distance) {
    const Feature& source = newest_.features[static_cast<std::size_t>(feature_)];
    const Frame& frame = *neighbour.frame;
    const RigidTransform T = frame.T_camera_world * newest_.T_camera_world.inverse();
    const double depth = (newest_.T_camera_world * point_).z();
    if (!(depth > 0.0) || !((T * (depth * camera_.bearing(source.pixel))).z() > 0.0)) return false;
    Eigen::Matrix2d warp = predictWarp(camera_, source.pixel, depth, T);
    const DistortedPixel raw_expected = camera_.distortWithJacobian(expected);
    if (camera_.model != LensModel::kNone) warp = raw_expected.jacobian * warp * pixel_by_raw_;
    const auto match = alignPatch({&newest_.pyramid, source.raw, source.level}, frame.pyramid,
                                  raw_expected.raw, warp, AlignmentLimits{});
    if (!match) return false;
    const View view{frame.T_camera_world, camera_.undistort(match->raw), frame.pyramid.scale(match->level)};
    if ((view.pixel - expected).norm() > max_distance * view.sigma) return false;
    views_.push_back(view);
    keyframes_.push_back(neighbour.id);
    return true;
  }

  /// Triangulates from all views so far, without views that do not fit.
  bool settle(const TriangulationParams& params) {
    auto point = triangulate(camera_, views_);
    if (!point) return false;
    for (std::size_t i = views_.size(); i-- > 1;) {
      if (reprojectsWithin(camera_, *point, views_[i], params.max_error)) continue;
      if (views_.size() == 2) return false;
      views_.erase(views_.begin() + static_cast<std::ptrdiff_t>(i));
      keyframes_.erase(keyframes_.begin() + static_cast<std::ptrdiff_t>(i));
      point = triangulate(camera_, views_);
      if (!point) return false;
    }
    if (!reprojectsWithin(camera_, *point, views_.front(), params.max_error)) return false;
    if (parallax(*point, views_) < degreesToRadians(params.min_parallax_deg)) return false;
    point_ = *point;
    return true;
  }

  const Eigen::Vector3d& point() const { return point_; }

  Landmark landmark() const {
    const Feature& source = newest_.features[static_cast<std::size_t>(feature_)];
    Landmark made;
    made.position = point_;
    std::copy_n(newest_.descriptor(feature_), made.descriptor.size(), made.descriptor.begin());
    made.reference = made.created = map_.keyframes().back().id;
    made.reference_raw = source.raw;
    made.reference_level = source.level;
    made.visible = made.found = 1;
    for (std::size_t i = views_.size(); i-- > 0;) {
      made.observations.push_back({keyframes_[i], views_[i].pixel, views_[i].sigma, 0});
    }
    std::sort(made.observations.begin(), made.observations.end(),
              [](const auto& a, const auto& b) { return a.keyframe < b.keyframe; });
    return made;
  }

 private:
  /// Ray of a view as a unit vector in the world's axes.
  Eigen::Vector3d rayOf(const View& view) const {
    return (view.T_camera_world.rotation.conjugate() * camera_.bearing(view.pixel)).normalized();
  }

  const CameraModel& camera_;
  const LocalMap& map_;
  const Frame& newest_;
  int feature_;
  Eigen::Matrix2d pixel_by_raw_;  // derivative of undistorting the feature
  Eigen::Vector3d point_ = Eigen::Vector3d::Zero();
  std::vector<View> views_;
  std::vector<KeyframeId> keyframes_;
};

}  // namespace

std::optional<Eigen::Vector3d> triangulate(const CameraModel& camera, const std::vector<View>& views) {
  if (views.size() < 2) return std::nullopt;
  // Start with the point nearest to all rays, with equal weights.
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const View& view : views) {
    const RigidTransform T_world_camera = view.T_camera_world.inverse();
    const Eigen::Vector3d ray = (T_world_camera.rotation * camera.bearing(view.pixel)).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    hessian += across;
    right += across * T_world_camera.translation;
  }
  const Eigen::LDLT<Eigen::Matrix3d> start(hessian);
  if (!(start.vectorD().minCoeff() > 1e-9)) return std::nullopt;
  Eigen::Vector3d point = start.solve(right);

  std::vector<Eigen::Matrix3d> rotations;
  rotations.reserve(views.size());
  for (const View& view : views) rotations.push_back(view.T_camera_world.rotation.toRotationMatrix());
  for (int step = 0; step < kRefinementSteps; ++step) {
    hessian.setZero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < views.size(); ++i) {
      const View& view = views[i];
      const Reprojection reprojection =
          reproject(camera, rotations[i] * point + view.T_camera_world.translation, view.pixel);
      if (!(reprojection.depth > 0.0)) return std::nullopt;
      const Eigen::Matrix<double, 2, 3> jacobian = reprojection.byPoint(rotations[i]) / view.sigma;
      hessian += jacobian.transpose() * jacobian;
      gradient += jacobian.transpose() * reprojection.error / view.sigma;
    }
    const Eigen::Vector3d increment = -hessian.ldlt().solve(gradient);
    if (!increment.allFinite()) return std::nullopt;
    point += increment;
    if (increment.squaredNorm() < 1e-12 * point.squaredNorm()) break;
  }
  for (const View& view : views) {
    if (!((view.T_camera_world * point).z() > 0.0)) return std::nullopt;
  }
  return point;
}

double parallax(const Eigen::Vector3d& point, const std::vector<View>& views) {
  double smallest_cosine = 1.0;
  for (std::size_t a = 0; a < views.size(); ++a) {
    const Eigen::Vector3d ray_a = (point - views[a].T_camera_world.inverse().translation).normalized();
    for (std::size_t b = a + 1; b < views.size(); ++b) {
      const Eigen::Vector3d ray_b = (point - views[b].T_camera_world.inverse().translation).normalized();
      smallest_cosine = std::min(smallest_cosine, ray_a.dot(ray_b));
    }
  }
  return std::acos(std::max(-1.0, smallest_cosine));
}

int addLandmarks(const CameraModel& camera, LocalMap& map, const TriangulationParams& params,
                 WorkerPool& workers) {
  if (map.keyframes().size() < 2) return 0;
  Frame& newest = *map.keyframes().back().frame;
  refreshFeatures(newest, camera);

  std::vector<const Keyframe*> neighbours;
  std::vector<EpipolarSearch> searches;
  const double depth = map.medianDepth(newest.T_camera_world);
  for (std::size_t i = map.keyframes().size() - 1; i-- > 0;) {
    if (static_cast<int>(neighbours.size()) >= params.neighbours) break;
    const Keyframe& neighbour = map.keyframes()[i];
    if ((neighbour.frame->centre() - newest.centre()).norm() < kLeastBaseline * depth) continue;
    neighbours.push_back(&neighbour);
    if (static_cast<int>(searches.size()) >= params.searched) continue;
    refreshFeatures(*neighbour.frame, camera);
    searches.emplace_back(camera, newest, *neighbour.frame, explainedFeatures(*neighbour.frame, kTakenRadius),
                          params.max_epipolar_error);
  }

  std::vector<bool> explained = explainedFeatures(newest, params.spacing);
  const auto find_landmark = [&](int feature) -> std::optional<Landmark> {
    for (std::size_t n = 0; n < searches.size(); ++n) {
      const int match = searches[n].find(feature);
      if (match < 0) continue;
      Candidate candidate(camera, map, feature);
      if (!candidate.start(*neighbours[n], match, params)) continue;
      for (std::size_t other = 0; other < neighbours.size(); ++other) {
        if (other == n) continue;
        const Eigen::Vector3d x = neighbours[other]->frame->T_camera_world * candidate.point();
        if (x.z() > 0.0) candidate.look(*neighbours[other], camera.project(x), params.max_epipolar_error);
      }
      if (candidate.settle(params)) return candidate.landmark();
    }
    return std::nullopt;
  };
  // The features of a batch are processed in parallel. Afterwards those that belong to a new landmark of the same
  // batch are dropped: so the result is that of processing them one after the other.
  const int features = static_cast<int>(newest.features.size());
  int added = 0;
  for (int begin = 0; begin < features && added < params.max_new; begin += kBatch) {
    const int end = std::min(features, begin + kBatch);
    std::vector<std::optional<Landmark>> found(static_cast<std::size_t>(end - begin));
    workers.run((end - begin + kShare - 1) / kShare, [&](int share) {
      const int share_begin = begin + share * kShare;
      for (int feature = share_begin; feature < std::min(end, share_begin + kShare); ++feature) {
        if (explained[static_cast<std::size_t>(feature)]) continue;
        found[static_cast<std::size_t>(feature - begin)] = find_landmark(feature);
      }
    });
    for (int feature = begin; feature < end && added < params.max_new; ++feature) {
      auto& landmark = found[static_cast<std::size_t>(feature - begin)];
      if (!landmark || explained[static_cast<std::size_t>(feature)]) continue;
      const LandmarkObservation here = landmark->observations.back();
      const LandmarkId id = map.addLandmark(std::move(*landmark));
      newest.observations.push_back(
          {id, here.pixel, here.sigma, newest.features[static_cast<std::size_t>(feature)].level});
      newest.grid.forEachNear(here.pixel, params.spacing, [&](const PointGrid::Point& point) {
        if ((point.pixel - here.pixel).squaredNorm() < params.spacing * params.spacing)
          explained[static_cast<std::size_t>(point.feature)] = true;
      });
      ++added;
    }
  }
  return added;
}

}  // namespace ratslam
