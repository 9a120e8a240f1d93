#include "ratslam/system/map_merge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ratslam/common/angles.h"
#include "ratslam/experience_map/solver/pose_graph.h"
#include "ratslam/experience_map/solver/standing.h"
#include "ratslam/system/map_fit.h"
#include "ratslam/system/pipeline.h"

namespace ratslam {
namespace {

/// Least time between two views of the same experience, like the period of a camera.
constexpr double kViewPeriod = 0.1;  // [s]
/// Longer steps of a thinned path are divided.
constexpr double kLongestStep = 0.5;  // [s]
constexpr int kMostSteps = 1000;

/// Parameters of the odometry stream for the replay.
OdometryStreamParams patient() {
  OdometryStreamParams params;
  params.odometry_gap = 1e6;  // a long step of the thinned path is no silence: the robot stood still
  return params;
}

PipelineParams paramsOf(const std::map<std::string, std::string>& texts) {
  ParameterMap parameters;
  PipelineParams params;
  params.visitFields([&](const std::string& key, auto& field, const Bounds&, const char*) {
    const auto found = texts.find(key);
    if (found == texts.end()) return;
    ParameterValue value;
    value.text = found->second;
    value.origin = "the map";
    if constexpr (std::is_same_v<std::decay_t<decltype(field)>, std::vector<double>>) {
      value.is_list = true;
      std::istringstream words(found->second);
      for (std::string word; words >> word;) value.elements.push_back(word);
    }
    parameters.set(key, value);
  });
  return PipelineParams::fromMap(parameters);
}

/// The stages of a map.
struct Stages {
  Stages(const PipelineParams& params, const State& state)
      : local_view(params.local_view, params.recall_geometry, patient()),
        pose_cells(params.pose_cells, patient()),
        map(params.experience_map, local_view.geometrySource(), patient()) {
    local_view.load(state.child("local_view"));
    pose_cells.load(state.child("pose_cells"));
    map.load(state.child("experience_map"));
    // After a loss of memory the nodes' numbers of experiences differ.
    const auto numbers = state.child("experience_map").get<std::vector<std::uint32_t>>("experience_of");
    for (std::uint32_t id = 0; id < numbers.size(); ++id) {
      if (numbers[id] != id) {
        throw std::runtime_error(
            "the pose cells have lost their memory while this map was made: what they call experience " +
            std::to_string(id) + " is another one in the map");
      }
    }
    if (pose_cells.cells().experiences() != map.map().graph().experiences().size()) {
      throw std::runtime_error("pose cells and experience map do not know the same places: " +
                               std::to_string(pose_cells.cells().experiences()) + " and " +
                               std::to_string(map.map().graph().experiences().size()));
    }
  }

  LocalViewStage local_view;
  PoseCellStage pose_cells;
  MapStage map;
};

/// Component of each experience. A component has the number of its first experience.
std::vector<std::uint32_t> componentsOf(const ExperienceGraph& graph) {
  std::vector<std::uint32_t> parent(graph.experiences().size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](std::uint32_t id) {
    while (parent[id] != id) id = parent[id] = parent[parent[id]];
    return id;
  };
  for (const Link& link : graph.links()) {
    const std::uint32_t from = root(link.from);
    const std::uint32_t to = root(link.to);
    parent[std::max(from, to)] = std::min(from, to);
  }
  std::vector<std::uint32_t> component(parent.size());
  for (std::uint32_t id = 0; id < parent.size(); ++id) component[id] = root(id);
  return component;
}

/// Errors of a stretch of a map's path.
struct KnownErrors {
  Eigen::Matrix4d variance_per_metre = Eigen::Matrix4d::Zero();  ///< of x, y, z, yaw
  UnitOfLength unit;
};

/// The path of a map, with the experience at each pose and the uncertainty of the motion.
class KeptDrive {
 public:
  /// @param breaks  ends of the sessions after which another place may follow
  KeptDrive(const ExperienceMap& map, const State& saved, std::vector<Stamp> breaks)
      : path_(map.finalTrajectory()),
        component_(componentsOf(map.graph())),
        errors_(path_.size()),
        breaks_(std::move(breaks)) {
    Trajectory trajectory;
    saved.get("trajectory", trajectory);
    std::vector<std::uint32_t> experience_of;  // each frame
    std::vector<std::optional<std::uint32_t>> own;
    for (std::uint32_t id = 0; id < map.graph().experiences().size(); ++id) {
      const std::uint32_t frame = map.frameOf(id);
      if (frame >= own.size()) own.resize(frame + 1);
      own[frame] = id;
    }
    std::optional<std::uint32_t> last_frame;
    for (std::size_t k = 0; k < path_.size(); ++k) {
      const std::uint32_t frame = trajectory.samples()[k].frame;
      if (last_frame && *last_frame == frame) {
        at_.push_back(at_.back());
        continue;
      }
      last_frame = frame;
      const bool created = frame < own.size() && own[frame];
      at_.push_back(created ? *own[frame] : nearest(map.graph(), path_[k].pose));
    }
    if (saved.child("solver").hasChild("graph")) readErrors(saved.child("solver").child("graph"), trajectory);
    for (std::optional<KnownErrors>& errors : errors_) {
      if (errors) errors->unit.constant_sigma = map.unitSigma();
    }
  }

  const std::vector<StampedPose>& path() const { return path_; }
  std::uint32_t at(std::size_t pose) const { return at_[pose]; }
  /// Errors of the motion from the pose before; none if the map has none.
  const std::optional<KnownErrors>& errors(std::size_t pose) const { return errors_[pose]; }

  /// Whether the motion from the pose before to pose `next` is known.
  bool goesOn(std::size_t next) const {
    const Stamp before = path_[next - 1].stamp;
    const Stamp now = path_[next].stamp;
    const bool broken =
        std::any_of(breaks_.begin(), breaks_.end(), [&](Stamp end) { return before <= end && now > end; });
    return now > before && !broken && component_[at_[next]] == component_[at_[next - 1]];
  }

 private:
  /// Reads the errors from the graph, which has a constraint for the motion from each frame to the next.
  void readErrors(const State& graph, const Trajectory& trajectory) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, Constraint> ways;
    for (const Constraint& way : graph.get<std::vector<Constraint>>("constraints")) {
      if (!way.closes()) ways[{way.from, way.to}] = way;
    }
    const auto& samples = trajectory.samples();
    double length = 0.0;
    for (std::size_t k = 1, first = 1; k < samples.size(); ++k) {
      length += std::hypot(path_[k].pose.x - path_[k - 1].pose.x, path_[k].pose.y - path_[k - 1].pose.y);
      if (samples[k].frame == samples[k - 1].frame) continue;
      const auto way = ways.find({samples[k - 1].frame, samples[k].frame});
      for (; first <= k; ++first) {
        if (way != ways.end() && length > 0.0) errors_[first] = errorsOf(way->second, length);
      }
      length = 0.0;
    }
  }

  static KnownErrors errorsOf(const Constraint& way, double length) {
    KnownErrors errors;
    errors.variance_per_metre = covarianceOf(way) / length;
    const double scale_variance = 1.0 / (way.scale_weight * way.scale_weight);
    const double lost = 1.0 - way.scale_kept * way.scale_kept;
    double walk = scale_variance;
    if (way.scale_kept > 0.0 && lost > 0.0) {  // inverts the sum of MotionError for an anchored unit
      errors.unit.anchor_sigma = std::sqrt(scale_variance / lost);
      walk = -2.0 * std::log(way.scale_kept) * scale_variance / lost;
    }
    errors.unit.walk_sigma = std::sqrt(walk / length);
    return errors;
  }

  /// Experience of a frame that a recall has made: the nearest one with about the same heading.
  static std::uint32_t nearest(const ExperienceGraph& graph, const MapPose& pose) {
    std::uint32_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t id = 0; id < graph.experiences().size(); ++id) {
      const MapPose& there = graph.pose(id);
      const double turned = wrapAngle(pose.yaw - there.yaw);
      if (std::abs(turned) > kPi / 4.0) continue;
      const double off = std::hypot(pose.x - there.x, pose.y - there.y) + std::abs(turned);
      if (off >= least) continue;
      best = id;
      least = off;
    }
    return best;
  }

  std::vector<StampedPose> path_;
  std::vector<std::uint32_t> component_;  ///< of each experience
  std::vector<std::uint32_t> at_;         ///< experience at each pose
  std::vector<std::optional<KnownErrors>> errors_;
  std::vector<Stamp> breaks_;
};

/// Ends of the sessions that the next one does not continue, as late as a continuation could begin.
std::vector<Stamp> breaksOf(const std::vector<MapSession>& sessions, double time_reset) {
  std::vector<Stamp> breaks;
  for (std::size_t i = 0; i + 1 < sessions.size(); ++i) {
    const double pause = secondsBetween(sessions[i].last_stamp, sessions[i + 1].first_stamp);
    if (pause > time_reset) breaks.push_back(sessions[i].last_stamp + stampFromSeconds(time_reset));
  }
  return breaks;
}

/// Replays the drive of one map through another map.
class Replay {
 public:
  Replay(Stages& known, const Stages& other, const PipelineParams& params)
      : known_(known), other_(other), panoramic_(params.local_view.panoramic) {}

  void drive(const KeptDrive& drive) {
    for (std::size_t k = 0; k < drive.path().size(); ++k) {
      const StampedPose& here = drive.path()[k];
      if (k == 0 || !drive.goesOn(k)) {
        interrupt();
      } else {
        move(drive.path()[k - 1], here, drive.errors(k));
      }
      if (k == 0 || !drive.goesOn(k)) addOdometry(here, {}, {});
      const std::uint32_t experience = drive.at(k);
      const bool other_place = !shown_ || *shown_ != experience;
      if (!other_place && secondsBetween(shown_at_, here.stamp) < kViewPeriod) continue;
      show(experience, here);
    }
  }

 private:
  void interrupt() {
    known_.pose_cells.interrupt();
    known_.map.interrupt();
    known_.local_view.interrupt();
    epoch_ = known_.local_view.epoch();
    shown_.reset();
    moved_ = {};
    moved_.assumed = true;
  }

  void move(const StampedPose& from, const StampedPose& to, const std::optional<KnownErrors>& errors) {
    const RelativePose whole = between(MapPose{from.pose.x, from.pose.y, from.pose.z, from.pose.yaw, 0.0},
                                       MapPose{to.pose.x, to.pose.y, to.pose.z, to.pose.yaw, 0.0});
    const double seconds = secondsBetween(from.stamp, to.stamp);
    const int steps =
        static_cast<int>(std::clamp(std::ceil(seconds / kLongestStep), 1.0, double{kMostSteps}));
    StampedPose last = from;
    for (int step = 1; step <= steps; ++step) {
      const double share = static_cast<double>(step) / steps;
      StampedPose next = to;
      if (step < steps) {
        next.stamp = from.stamp + static_cast<Stamp>(share * static_cast<double>(to.stamp - from.stamp));
        next.pose = compose(MapPose{from.pose.x, from.pose.y, from.pose.z, from.pose.yaw, 0.0},
                            {share * whole.x, share * whole.y, share * whole.z, share * whole.yaw});
        next.tilt = from.tilt.slerp(share, to.tilt);
      }
      addOdometry(next, last, errors);
      last = next;
    }
  }

  void addOdometry(const StampedPose& here, const std::optional<StampedPose>& before,
                   const std::optional<KnownErrors>& errors) {
    OdometrySample sample;
    sample.stamp = here.stamp;
    sample.epoch = epoch_;
    sample.pose = Eigen::Isometry3d::Identity();
    sample.pose->linear() = here.attitude().toRotationMatrix();
    sample.pose->translation() = Eigen::Vector3d(here.pose.x, here.pose.y, here.pose.z);
    if (before) {
      const double seconds = secondsBetween(before->stamp, here.stamp);
      const double turned = wrapAngle(here.pose.yaw - before->pose.yaw);
      const double forward = (here.pose.x - before->pose.x) * std::cos(here.pose.yaw) +
                             (here.pose.y - before->pose.y) * std::sin(here.pose.yaw);
      sample.speed = forward / seconds;
      sample.yaw_rate = turned / seconds;
      if (errors) {
        const Eigen::Matrix4d spread = errors->variance_per_metre * (std::abs(forward) / (seconds * seconds));
        sample.covariance = TwistCovariance::Zero();
        sample.covariance->diagonal() << spread(0, 0), spread(1, 1), spread(2, 2), 0.0, 0.0, spread(3, 3);
        sample.unit = errors->unit;
      }
      moved_.forward += forward;
      moved_.rotation += turned;
    }
    known_.pose_cells.addOdometry(sample);
    known_.map.addOdometry(sample);
  }

  /// Shows the view that was learned at an experience, at the present pose.
  void show(std::uint32_t experience, const StampedPose& here) {
    const std::optional<PlaceView> there = other_.pose_cells.cells().viewOf(experience);
    shown_ = experience;
    shown_at_ = here.stamp;
    if (!there) return;
    moved_.epoch = epoch_;
    LocalViewCells& cells = known_.local_view.cells();
    ViewEvent event =
        cells.observe(here.stamp, other_.local_view.cells().learned(there->view_id), cv::Mat(), moved_);
    moved_ = {};
    if (panoramic_) {
      const double turned =
          here.pose.yaw - other_.map.map().graph().pose(experience).yaw + there->relative_rad;
      event.relative_rad = wrapAngle(event.relative_rad + turned);
    }
    RecallGeometry geometry = cells.recallGeometry().value_or(RecallGeometry{});
    geometry.stamp = event.stamp;
    known_.map.addGeometry(geometry);
    known_.pose_cells.addView(event);
    for (const PoseCellDecision& decision : known_.pose_cells.drain())
      known_.map.addDecision(decision.action);
    known_.map.drain();
  }

  Stages& known_;
  const Stages& other_;
  bool panoramic_;
  std::uint32_t epoch_ = 0;
  ViewMotion moved_;
  std::optional<std::uint32_t> shown_;  ///< experience of the last view
  Stamp shown_at_ = 0;
};

/// Whether map `a` began before map `b`. Equal stamps are ordered by the bytes of the maps.
bool beganBefore(const MapCheckpoint& a, const MapCheckpoint& b) {
  const auto begin = [](const MapCheckpoint& map) {
    return map.sessions.empty() ? map.stamp : map.sessions.front().first_stamp;
  };
  if (begin(a) != begin(b)) return begin(a) < begin(b);
  if (a.stamp != b.stamp) return a.stamp < b.stamp;
  return a.state.toBytes() <= b.state.toBytes();
}

}  // namespace

MapMerge mergeMaps(const MapCheckpoint& a, const MapCheckpoint& b) {
  if (!beganBefore(a, b)) return mergeMaps(b, a);
  const PipelineParams params = paramsOf(a.parameters);
  if (params.recall_geometry.verifies()) {
    throw std::runtime_error("maps made with vt_verify = " + params.recall_geometry.verify +
                             " cannot be merged: recalls are verified by images, which a map does not keep");
  }
  if (holdTheSameDrive(a.state, b.state)) {
    throw std::runtime_error(
        "one of the maps holds the drive of the other one (pruned, or continued): merge takes maps of "
        "different "
        "drives");
  }
  Stages known(params, a.state);
  Stages other(params, b.state);
  MapMerge merge;
  merge.first_experiences = known.map.map().graph().experiences().size();
  merge.second_experiences = other.map.map().graph().experiences().size();
  other.map.map().settle();
  if (merge.second_experiences > 0) {
    const State& saved = b.state.child("experience_map").child("map");
    Replay(known, other, params)
        .drive(KeptDrive(other.map.map(), saved, breaksOf(b.sessions, params.images.time_reset)));
  }
  known.map.map().settle();
  merge.experiences = known.map.map().graph().experiences().size();
  const std::vector<std::uint32_t> components = componentsOf(known.map.map().graph());
  for (std::uint32_t id = 0; id < components.size(); ++id) merge.components += components[id] == id ? 1 : 0;
  merge.map.stamp = std::max(a.stamp, b.stamp);
  merge.map.parameters = a.parameters;
  merge.map.sessions = a.sessions;
  merge.map.sessions.insert(merge.map.sessions.end(), b.sessions.begin(), b.sessions.end());
  known.local_view.save(merge.map.state.child("local_view"));
  known.pose_cells.save(merge.map.state.child("pose_cells"));
  known.map.save(merge.map.state.child("experience_map"));
  return merge;
}

}  // namespace ratslam
