#include "ratslam/system/map_merge.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ratslam/common/angles.h"
#include "ratslam/system/map_fit.h"
#include "ratslam/system/map_merge_drive.h"
#include "ratslam/system/pipeline.h"

namespace ratslam {
namespace {

/// Least time between two views of the same experience, like the period of a camera.
constexpr double kViewPeriod = 0.1;  // [s]

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
    const std::vector<std::string> misfits = misfitsOf(state);
    if (!misfits.empty()) throw std::runtime_error(misfits.front());
  }

  LocalViewStage local_view;
  PoseCellStage pose_cells;
  MapStage map;
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
      const std::optional<std::uint32_t> seen = drive.seenAt(k);
      const bool still = shown_at_ && shown_ == seen;
      if (still && secondsBetween(*shown_at_, here.stamp) < kViewPeriod) continue;
      show(seen, here);
    }
  }

 private:
  void interrupt() {
    known_.pose_cells.interrupt();
    known_.map.interrupt();
    known_.local_view.interrupt();
    epoch_ = known_.local_view.epoch();
    shown_at_.reset();
    moved_ = {};
    moved_.assumed = true;
  }

  void move(const StampedPose& from, const StampedPose& to, const std::optional<KnownErrors>& errors) {
    const RelativePose whole = between(MapPose{from.pose.x, from.pose.y, from.pose.z, from.pose.yaw, 0.0},
                                       MapPose{to.pose.x, to.pose.y, to.pose.z, to.pose.yaw, 0.0});
    const double seconds = secondsBetween(from.stamp, to.stamp);
    // A share of an unmeasured step would err faster than an odometry can.
    const int steps = errors && errors->growWithTime() ? 1 : sharesOf(seconds);
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
      const DrivenStep step = drivenBetween(*before, here);
      sample.speed = step.forward / seconds;
      sample.yaw_rate = step.rotation / seconds;
      if (errors) {
        sample.covariance = errors->ofTwist(step.forward, seconds);
        sample.unit = errors->unit;
      }
      moved_.forward += step.forward;
      moved_.rotation += step.rotation;
    }
    known_.pose_cells.addOdometry(sample);
    known_.map.addOdometry(sample);
  }

  /// Shows the view that was learned at an experience, or a view of nothing, at the present pose.
  void show(std::optional<std::uint32_t> experience, const StampedPose& here) {
    shown_ = experience;
    shown_at_ = here.stamp;
    const std::optional<PlaceView> there =
        experience ? other_.pose_cells.cells().viewOf(*experience) : std::nullopt;
    View view;
    view.textured = there.has_value();
    if (there) view = other_.local_view.cells().learned(there->view_id);
    moved_.epoch = epoch_;
    LocalViewCells& cells = known_.local_view.cells();
    ViewEvent event = cells.observe(here.stamp, view, cv::Mat(), moved_);
    moved_ = {};
    if (panoramic_ && there) {
      const double turned =
          here.pose.yaw - other_.map.map().graph().pose(*experience).yaw + there->relative_rad;
      event.relative_rad = wrapAngle(event.relative_rad + turned);
    }
    RecallGeometry geometry;
    if (event.seen()) geometry = cells.recallGeometry().value_or(RecallGeometry{});
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
  std::optional<std::uint32_t> shown_;  ///< experience of the last view; none if it was of nothing
  std::optional<Stamp> shown_at_;       ///< none after interrupt()
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
  if (holdTheSameDrive(a, b)) {
    throw std::runtime_error(
        "one of the maps holds a drive of the other one (pruned, continued or merged): merge takes maps of "
        "different drives");
  }
  Stages known(params, a.state);
  Stages other(params, b.state);
  MapMerge merge;
  merge.first_experiences = known.map.map().graph().experiences().size();
  merge.second_experiences = other.map.map().graph().experiences().size();
  other.map.map().settle();
  if (merge.second_experiences > 0) {
    const State& saved = b.state.child("experience_map").child("map");
    const double reach = params.pose_cells.experience_distance * params.pose_cells.cell_size;
    const KeptDrive drive(other.map.map(), saved, breaksOf(b.sessions, params.images.time_reset), reach);
    Replay(known, other, params).drive(drive);
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
