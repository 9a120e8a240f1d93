#include "ratslam/local_view/recall/recall_geometry_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <utility>

#include "ratslam/camera/grey.h"
#include "ratslam/common/angles.h"
#include "ratslam/common/statistics.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam {
namespace {

// Distance of companions from the template [frames], in order of trial.
constexpr std::array<std::size_t, 3> kCompanionGaps{3, 6, 12};
constexpr std::size_t kRing = kCompanionGaps.back() + 1;
constexpr double kMinDepthSignal = 5.0;     // least median inverse depth of companion matches, in its sigmas
constexpr double kMinCompanionShare = 0.5;  // least share of inliers; with fewer they may agree by chance
constexpr int kDenser = 3;  // features of a present or companion image / features of a template
// If a pure rotation keeps at least this share of the inliers, it is the model.
constexpr double kMaxRotationShare = 0.9;

RecallPair pairOf(const RecallFeatures& anchor, const RecallFeatures& other, const RecallMatch& match) {
  const auto a = static_cast<std::size_t>(match.first);
  const auto b = static_cast<std::size_t>(match.second);
  return {anchor.bearings[a].cast<double>(), other.bearings[b].cast<double>(),
          std::hypot(static_cast<double>(anchor.sigmas[a]), static_cast<double>(other.sigmas[b])),
          std::nullopt};
}

/// Two views as a bundle, with one point and one observation per pair.
RecallBundle bundleOf(const RecallView& view, const std::vector<RecallPair>& pairs) {
  RecallBundle bundle;
  bundle.views = {view};
  for (const RecallPair& pair : pairs) {
    const int point = static_cast<int>(bundle.points.size());
    const double depth =
        pair.inverse_depth ? *pair.inverse_depth : inverseDepth(view, pair.anchor, pair.bearing);
    bundle.points.push_back({pair.anchor, depth, 0.0});
    bundle.observations.push_back({0, point, pair.bearing, pair.sigma, recallError(view, pair, depth) < 8.0});
  }
  return bundle;
}

/// Signal-to-noise ratio of the parallax: median of inverse depth / its sigma over a bundle's inlier points.
double depthSignal(const RecallBundle& bundle) {
  std::vector<double> signals;
  for (const RecallObservation& seen : bundle.observations) {
    const RecallPoint& point = bundle.points[static_cast<std::size_t>(seen.point)];
    if (seen.inlier) signals.push_back(point.inverse_depth / point.sigma);
  }
  return signals.empty() ? 0.0 : median(std::move(signals));
}

/// Fills in the geometry from the pose of the present image, in the axes of the template's camera (x forward, y left).
/// @param covariance of the view's (rotation, translation), 6 x 6
void describe(const RecallView& view, const Eigen::MatrixXd& covariance, RecallGeometry& geometry) {
  const Eigen::Matrix3d back = view.R.transpose();
  // Converts camera axes (x right, z forward) to planar axes (x forward, y left).
  Eigen::Matrix<double, 2, 3> plane;
  plane << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0;

  const Eigen::Vector2d ahead = plane * back.col(2);
  const Eigen::RowVector2d across(-ahead.y(), ahead.x());
  const Eigen::RowVector3d heading_by_rotation =
      across * plane * back * skew(Eigen::Vector3d::UnitZ()) / std::max(ahead.squaredNorm(), 1e-12);
  geometry.relative_rad = std::atan2(ahead.y(), ahead.x());
  geometry.sigma_rotation = std::min(kPi, std::sqrt(heading_by_rotation * covariance.topLeftCorner<3, 3>() *
                                                    heading_by_rotation.transpose()));

  const Eigen::Vector2d offset = plane * (-(back * view.t));
  const double length = offset.norm();
  Eigen::Matrix<double, 2, 6> offset_by_pose;
  offset_by_pose << -plane * back * skew(view.t), -plane * back;
  const Eigen::Matrix2d spread = offset_by_pose * covariance * offset_by_pose.transpose();
  const Eigen::Vector2d along = length > 0.0 ? Eigen::Vector2d(offset / length) : Eigen::Vector2d::UnitX();
  const Eigen::Vector2d aside(-along.y(), along.x());
  geometry.direction_rad = std::atan2(along.y(), along.x());
  const double sideways = std::sqrt(aside.dot(spread * aside));
  geometry.sigma_direction = sideways < kPi * length ? sideways / length : kPi;
  if (view.motion == RecallMotion::kFree) {
    geometry.distance_ratio = length;
    geometry.sigma_ratio = std::sqrt(along.dot(spread * along));
  }
}

}  // namespace

RecallGeometryEstimator::RecallGeometryEstimator(const RecallGeometryParams& params,
                                                 const CameraModel& camera)
    : params_(params), camera_(camera), active_(params.verify == "orb") {
  params_.validate();
  if (active_) camera_.validate();
}

void RecallGeometryEstimator::requireSize(const cv::Mat& image) const {
  if (image.cols == camera_.width && image.rows == camera_.height) return;
  throwBadValue("image size", std::to_string(image.cols) + "x" + std::to_string(image.rows),
                "the camera's calibration is for " + std::to_string(camera_.width) + "x" +
                    std::to_string(camera_.height));
}

RecallGeometryEstimator::Frame& RecallGeometryEstimator::present(Stamp stamp, const cv::Mat& image) {
  requireSize(image);
  cv::Mat grey = eightBitGrey(image);
  // The caller may reuse its memory for the next image.
  if (grey.data == image.data) grey = grey.clone();
  if (!ring_.empty() && stamp < ring_.back().stamp) ring_.clear();
  if (!ring_.empty() && stamp == ring_.back().stamp) {
    Frame& last = ring_.back();
    if (std::equal(grey.datastart, grey.dataend, last.grey.datastart)) return last;
    ring_.pop_back();  // another image with the same stamp replaces it
  }
  ring_.push_back({stamp, std::move(grey), std::nullopt});
  if (ring_.size() > kRing) ring_.pop_front();
  return ring_.back();
}

const RecallFeatures& RecallGeometryEstimator::featuresOf(Frame& frame) const {
  if (!frame.features)
    frame.features = extractRecallFeatures(frame.grey, camera_, kDenser * params_.features);
  return *frame.features;
}

void RecallGeometryEstimator::frame(Stamp stamp, const cv::Mat& image) {
  if (active_) present(stamp, image);
}

std::optional<RecallGeometryEstimator::Companion> RecallGeometryEstimator::companionOf(
    const RecallFeatures& features, Frame& frame) const {
  const RecallFeatures& other = featuresOf(frame);
  const std::vector<RecallMatch> matches = matchRecallFeatures(features, other);
  std::vector<RecallPair> pairs;
  for (const RecallMatch& match : matches) pairs.push_back(pairOf(features, other, match));
  const std::optional<RecallView> start = epipolarConsensus(pairs, params_.min_inliers);
  if (!start) return std::nullopt;
  RecallBundle bundle = bundleOf(*start, pairs);
  if (!refineRecallBundle(bundle)) return std::nullopt;
  const double least =
      std::max(1.0 * params_.min_inliers, kMinCompanionShare * static_cast<double>(pairs.size()));
  if (inlierCount(bundle, 0) < least) return std::nullopt;
  if (depthSignal(bundle) < kMinDepthSignal) return std::nullopt;

  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  Companion companion{frame.stamp, bundle.views[0], {}, {}, {}};
  companion.bearings.assign(features.size(), Eigen::Vector2f::Constant(kNone));
  companion.inverse_depths.assign(features.size(), kNone);
  companion.sigmas.assign(features.size(), kNone);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!bundle.observations[i].inlier) continue;
    const auto feature = static_cast<std::size_t>(matches[i].first);
    companion.bearings[feature] = other.bearings[static_cast<std::size_t>(matches[i].second)];
    companion.inverse_depths[feature] = static_cast<float>(bundle.points[i].inverse_depth);
    companion.sigmas[feature] = static_cast<float>(pairs[i].sigma);
  }
  return companion;
}

void RecallGeometryEstimator::addCompanion(RecallBundle& bundle, const Template& then,
                                           const std::vector<RecallMatch>& matches) {
  const Companion& companion = *then.companion;
  const int view = static_cast<int>(bundle.views.size());
  bundle.views.push_back(companion.view);
  std::vector<int> point_of(then.features.size(), -1);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    point_of[static_cast<std::size_t>(matches[i].first)] = static_cast<int>(i);
  }
  for (std::size_t i = 0; i < companion.bearings.size(); ++i) {
    if (std::isnan(companion.inverse_depths[i])) continue;
    if (point_of[i] < 0) {
      point_of[i] = static_cast<int>(bundle.points.size());
      bundle.points.push_back(
          {then.features.bearings[i].cast<double>(), static_cast<double>(companion.inverse_depths[i]), 0.0});
    }
    bundle.observations.push_back({view, point_of[i], companion.bearings[i].cast<double>(),
                                   static_cast<double>(companion.sigmas[i]), true});
  }
}

void RecallGeometryEstimator::learned(Stamp stamp, const cv::Mat& image, std::uint32_t view_id) {
  if (!active_) return;
  Template learnt{
      stamp, firstFeatures(featuresOf(present(stamp, image)), static_cast<std::size_t>(params_.features)),
      std::nullopt};
  for (const std::size_t gap : kCompanionGaps) {
    if (gap >= ring_.size()) break;
    learnt.companion = companionOf(learnt.features, ring_[ring_.size() - 1 - gap]);
    if (learnt.companion) break;
  }
  templates_[view_id] = std::make_shared<const Template>(std::move(learnt));
  if (templates_.size() > static_cast<std::size_t>(params_.max_templates)) dropOne();
}

void RecallGeometryEstimator::dropOne() {
  auto victim = templates_.begin();
  Stamp closest = std::numeric_limits<Stamp>::max();
  for (auto it = templates_.begin(); it != templates_.end(); ++it) {
    if (it == templates_.begin() || std::next(it) == templates_.end()) continue;
    const Stamp apart = std::abs(std::next(it)->second->stamp - std::prev(it)->second->stamp);
    if (apart < closest) {
      closest = apart;
      victim = it;
    }
  }
  templates_.erase(victim);
}

std::optional<RecallGeometry> RecallGeometryEstimator::verify(Stamp stamp, const cv::Mat& image,
                                                              std::uint32_t view_id) {
  RecallGeometry geometry;
  geometry.stamp = stamp;
  geometry.view_id = view_id;
  geometry.sigma_rotation = kPi;
  geometry.sigma_direction = kPi;
  geometry.template_stamp = stamp;
  geometry.companion_stamp = stamp;
  if (!active_) return geometry;
  const RecallFeatures& now = featuresOf(present(stamp, image));
  const auto found = templates_.find(view_id);
  if (found == templates_.end()) return geometry;
  const Template& then = *found->second;
  geometry.template_stamp = then.stamp;
  geometry.companion_stamp = then.companion ? then.companion->stamp : then.stamp;
  if (then.features.size() < 2 * static_cast<std::size_t>(params_.min_inliers)) return geometry;

  const std::vector<RecallMatch> matches = matchRecallFeatures(then.features, now);
  std::vector<RecallPair> pairs;
  for (const RecallMatch& match : matches) {
    pairs.push_back(pairOf(then.features, now, match));
    const float depth =
        then.companion ? then.companion->inverse_depths[static_cast<std::size_t>(match.first)] : 0.0F;
    if (then.companion && !std::isnan(depth)) pairs.back().inverse_depth = depth;
  }
  const std::optional<RecallView> start = then.companion ? resectionConsensus(pairs, params_.min_inliers / 2)
                                                         : epipolarConsensus(pairs, params_.min_inliers);
  if (!start) return std::nullopt;
  RecallBundle bundle = bundleOf(*start, pairs);
  if (then.companion) {
    addCompanion(bundle, then, matches);
  }
  std::optional<Eigen::MatrixXd> covariance = refineRecallBundle(bundle);
  geometry.inliers = inlierCount(bundle, 0);
  if (!covariance || geometry.inliers < params_.min_inliers) return std::nullopt;

  if (!then.companion) {
    RecallBundle turned = bundle;
    turned.views[0].motion = RecallMotion::kRotation;
    turned.views[0].t.setZero();
    for (RecallPoint& point : turned.points) point.inverse_depth = 0.0;
    const std::optional<Eigen::MatrixXd> turned_covariance = refineRecallBundle(turned);
    if (turned_covariance && inlierCount(turned, 0) >= kMaxRotationShare * geometry.inliers) {
      bundle = turned;
      covariance = turned_covariance;
    }
  }
  describe(bundle.views[0], covariance->topLeftCorner<6, 6>(), geometry);
  return geometry;
}

std::size_t RecallGeometryEstimator::memoryBytes() const {
  std::size_t bytes = 0;
  for (const auto& [id, shared] : templates_) {
    const Template& stored = *shared;
    const RecallFeatures& f = stored.features;
    bytes += sizeof(id) + sizeof(stored) + f.bearings.capacity() * sizeof(Eigen::Vector2f) +
             f.sigmas.capacity() * sizeof(float) + f.descriptors.total() * f.descriptors.elemSize();
    if (!stored.companion) continue;
    const Companion& c = *stored.companion;
    bytes += c.bearings.capacity() * sizeof(Eigen::Vector2f) +
             (c.inverse_depths.capacity() + c.sigmas.capacity()) * sizeof(float);
  }
  return bytes;
}

}  // namespace ratslam
