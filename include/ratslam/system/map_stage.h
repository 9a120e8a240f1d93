/// The experience map fed by its stamped streams: odometry, decisions of the pose cells, and, where recalls
/// are verified by image geometry or belief recalls, what that says of where the robot is.
///
/// A decision is processed once every stream has reached its stamp: motion up to it first, then the action.
/// The result depends on stamps and values alone.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/events.h"
#include "ratslam/experience_map/experience_map.h"
#include "ratslam/system/event_gate.h"
#include "ratslam/system/parameter_changes.h"

namespace ratslam {

class MapStage {
 public:
  /// @param geometry  what is measured of recalls: unless nothing is, a RecallGeometry accompanies every decision
  MapStage(const ExperienceMapParams& params, GeometrySource geometry,
           const OdometryStreamParams& stream = {});

  SampleVerdict addOdometry(const OdometrySample& sample) { return gate_.addOdometry(sample); }
  /// One per view event, kind kNone included: it tells how far the pose cells have got.
  /// None is ever left out: the pose cells have numbered their experiences by them. One that is a little late
  /// counts as simultaneous with the one before. @return false where time has gone back
  bool addDecision(const TopologicalAction& action);
  /// Where no decision asks for so long that too much of it waits, the oldest is forgotten: a decision of its stamp
  /// then counts as not measured.
  void addGeometry(const RecallGeometry& geometry);

  /// Processes what has become possible. An action that names experiences that do not exist is refused, the map
  /// unharmed. @return stamps of the processed decisions, oldest first
  /// @param which  kAll: neither the odometry nor the geometry is waited for
  std::vector<Stamp> drain(Passing which = Passing::kReached);
  /// Why decisions were refused since the last call: the map could not follow them, and went on with the next.
  std::vector<std::string> takeRefusals();

  std::size_t waitingDecisions() const { return gate_.size(); }
  std::size_t waitingGeometry() const { return geometry_.size(); }
  /// Geometry that was forgotten before a decision asked for it.
  std::size_t forgottenGeometry() const { return forgotten_; }
  /// Where the robot is by all odometry that has come, ahead of the decisions.
  StampedPose latestPose() const;
  const OdometryTimeline& odometry() const { return gate_.odometry(); }
  const ExperienceMap& map() const { return map_; }
  ExperienceMap& map() { return map_; }

  /// Session of the experiences' numbers. Its numbers are those of the pose cells, which the map's own need
  /// not equal: when the pose cells begin a session that knows less, what it numbers anew is new in the map as
  /// well; an experience that this map does not know, because it has lost its memory, is created when it is
  /// recalled.
  const NumberSession& session() const { return session_; }
  /// Experiences that were recalled and had to be created.
  std::size_t recreated() const { return recreated_; }

  /// Forgets what the streams have brought: what comes next is another drive, or another part of this one.
  /// How the robot got there is not known: it begins a new stretch, which joins the others once something
  /// known is recalled.
  void interrupt();

  /// Whether the map may change; else recalls only say where the robot is in it.
  void setLearning(bool learning) { map_.setLearning(learning); }

  /// Other parameters for all decisions later than `after`: those of changeableKeys may differ.
  /// @throws std::invalid_argument for bad ones
  void change(Stamp after, const ExperienceMapParams& params) {
    params.validate();
    changes_.add(after, params);
  }
  /// The stamp after which a change that is made now would hold.
  Stamp latestProcessed() const { return gate_.latestPassed(); }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit
  void load(const State& state);

 private:
  void process(const TopologicalAction& action);
  bool processOrRefuse(const TopologicalAction& action);
  bool geometryIsMissing(Stamp stamp) const;
  TopologicalAction inNumbersOfTheMap(TopologicalAction action);
  std::optional<RecallGeometry> takeGeometry(Stamp stamp);
  void thinOutWay();
  std::optional<Eigen::Vector3d> odometryAt(Stamp stamp) const;

  ExperienceMap map_;
  TimedChanges<ExperienceMapParams> changes_;
  std::vector<std::string> refusals_;
  NumberSession session_;
  std::vector<std::uint32_t> experience_of_;  ///< number in the map of each number in the pose cells
  std::uint64_t recreated_ = 0;
  GeometrySource geometry_source_;
  bool use_height_;
  OdometryStreamParams stream_;
  EventGate<TopologicalAction> gate_;
  std::map<Stamp, RecallGeometry> geometry_;
  std::optional<Stamp> newest_geometry_;  ///< that has come: none up to here will
  std::size_t forgotten_ = 0;
  bool started_ = false;
  std::optional<Stamp> last_processed_;
  std::uint64_t beginnings_ = 0;  ///< of the odometry's time, as far as the map has followed
  /// Dead reckoning at the stamp of each decision, in the odometry's unit, for the ways that recall geometry compares
  /// with. Once there are too many, every other one of the older half goes.
  struct Waypoint {
    Stamp stamp = 0;
    Eigen::Vector3d place = Eigen::Vector3d::Zero();

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("place", place);
    }
  };
  std::vector<Waypoint> way_;
  double way_yaw_ = 0.0;
};

}  // namespace ratslam
