/// The experience map with its stamped streams: odometry, decisions of the pose cells, and, if recalls are verified or
/// made by belief, recall geometry.
///
/// A decision is processed once every stream has reached its stamp: first the motion up to it, then the action. The
/// result depends only on stamps and values.
#pragma once

#include <deque>
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
  /// @param geometry  source of recall geometry; unless it is kNone, every decision has a RecallGeometry of its stamp
  MapStage(const ExperienceMapParams& params, GeometrySource geometry,
           const OdometryStreamParams& stream = {});

  SampleVerdict addOdometry(const OdometrySample& sample) { return gate_.addOdometry(sample); }
  /// Samples that were held by their stamps and have been decided (event_gate.h).
  std::vector<DecidedSample> takeDecided() { return gate_.takeDecided(); }
  /// Announces an event of this stamp, which may decide on a held sample.
  void expect(Stamp stamp) { gate_.expect(stamp); }
  /// To be called after the last sample.
  void endOdometry() { gate_.acceptHeld(); }
  /// Adds the decision of a view event, also one of kind kNone. No decision may be left out, because the map counts the
  /// new experiences. A late decision gets the stamp of the one before it.
  /// @return false if time has gone back
  bool addDecision(const TopologicalAction& action);
  /// Adds the geometry of a recall. If too many wait for their decisions, the oldest is forgotten; its decision then
  /// counts as unmeasured.
  void addGeometry(const RecallGeometry& geometry);

  /// Processes all decisions that every stream has reached. An action with an experience that does not exist is refused
  /// and changes nothing. @return stamps of the processed decisions, oldest first
  /// @param which  kAll: do not wait for odometry and geometry
  std::vector<Stamp> drain(Passing which = Passing::kReached);
  /// Reasons of the decisions that were refused since the last call.
  std::vector<std::string> takeRefusals();

  std::size_t waitingDecisions() const { return gate_.size(); }
  /// Stamp of the newest decision; none after interrupt().
  std::optional<Stamp> lastDecision() const { return gate_.lastEvent(); }
  /// Number of geometries that were forgotten before their decision came.
  std::size_t forgottenGeometry() const { return forgotten_; }
  /// Pose of the robot by all odometry so far, also that after the last decision. A call takes the samples since the
  /// last one.
  StampedPose latestPose();
  const OdometryTimeline& odometry() const { return gate_.odometry(); }
  const ExperienceMap& map() const { return map_; }
  ExperienceMap& map() { return map_; }

  /// Session of the experiences' numbers. They are numbers of the pose cells and may differ from the map's own numbers.
  /// If a new session of the pose cells knows fewer experiences, the numbers it gives again are new experiences of the
  /// map. If the map has lost an experience that the pose cells know, it is created when it is recalled.
  const NumberSession& session() const { return session_; }
  /// Number of experiences that were recalled and had to be created.
  std::size_t recreated() const { return recreated_; }

  /// Clears the streams, before another drive or another part of the same drive. The motion in between is unknown. So
  /// the path begins unconnected, until a known place is recalled.
  void interrupt();

  /// Whether the map may change. If not, recalls only place the robot in it.
  void setLearning(bool learning) { map_.setLearning(learning); }

  /// Sets other parameters for all decisions later than `after`. Only those of changeableKeys may differ.
  /// @throws std::invalid_argument for bad ones
  void change(Stamp after, const ExperienceMapParams& params) {
    params.validate();
    changes_.add(after, params);
  }
  /// The stamp after which a change made now holds.
  Stamp latestProcessed() const { return changes_.latest(gate_.latestPassed()); }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit
  void load(const State& state);

 private:
  void process(const TopologicalAction& action);
  bool processOrRefuse(const TopologicalAction& action);
  bool geometryIsMissing(Stamp stamp) const;
  TopologicalAction inNumbersOfTheMap(TopologicalAction action);
  std::size_t earlierGeometry(Stamp stamp) const;
  bool beginsAnotherTime(std::size_t index) const;
  void useUpGeometry(std::size_t count);
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
  std::deque<RecallGeometry> geometry_;  ///< in the order of the images, which may be ahead of the decisions
  /// Stamp of the last geometry that is used up, of the time of the decisions.
  std::optional<Stamp> used_geometry_;
  std::size_t forgotten_ = 0;
  bool started_ = false;
  std::optional<Stamp> last_processed_;
  std::uint64_t beginnings_ = 0;  ///< beginnings of the odometry's time that the map has processed
  /// Dead reckoning at the stamp of each decision, in the odometry's unit. It gives the distance companion -> template
  /// for recall geometry. If there are too many, every second one of the older half is dropped.
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
  std::uint32_t next_view_ = 0;    ///< above the numbers of all views up to the last decision
  std::uint32_t oldest_view_ = 0;  ///< views from this number on were learned on the way
  /// Motion after the last decision, as far as latestPose() has added it up.
  struct Ahead {
    std::uint64_t beginnings = 0;
    Stamp from = 0;  ///< end of the motion that the map has
    Stamp to = 0;
    Motion motion;
    Eigen::Quaterniond tilt = Eigen::Quaterniond::Identity();
  };
  std::optional<Ahead> ahead_;
};

}  // namespace ratslam
