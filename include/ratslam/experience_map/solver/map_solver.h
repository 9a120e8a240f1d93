/// What ExperienceMap asks of a solver: to place the robot when a place is created or recalled, and to keep
/// the poses of the map consistent with what was measured.
///
/// A solver places things in frames. relaxation.h knows one frame per experience; pose_graph_map.h adds one
/// per recall, because the robot that recognises a place does not stand exactly where it stood then.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "ratslam/events.h"
#include "ratslam/experience_map/experience_graph.h"
#include "ratslam/experience_map/solver/standing.h"

namespace ratslam {

class State;

/// Where the robot is: its motion since it was last placed in a frame, or beside one.
struct RobotPlace {
  std::uint32_t frame = 0;
  Motion motion;      ///< its pose is in the frame, its errors are those since the robot was placed
  bool lost = false;  ///< how it got from there to where it is was not measured
  Standing standing{};

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("frame", frame);
    fields("motion", motion);
    fields("lost", lost);
    fields("standing", standing);
  }
};

/// What a stretch of the robot's way was after all.
struct CorrectedWay {
  std::uint32_t from = 0;  ///< frame in which the stretch begins
  RelativePose before;     ///< of the robot in that frame, where it begins
  /// Frames made since, in the axes of the robot where the stretch begins, in the order of the way.
  std::vector<std::pair<std::uint32_t, RelativePose>> frames;
  std::size_t within = 0;  ///< how many of them lie within the stretch
  /// Of the last of those (x, y, z, yaw).
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
};

class MapSolver {
 public:
  MapSolver() = default;
  MapSolver(const MapSolver&) = delete;
  MapSolver& operator=(const MapSolver&) = delete;
  virtual ~MapSolver() = default;

  /// Pose of a frame in the map.
  virtual MapPose framePose(const ExperienceGraph& graph, std::uint32_t frame) const = 0;

  /// Frame of an experience.
  virtual std::uint32_t frameOf(std::uint32_t experience) const = 0;

  /// How many frames there are.
  virtual std::size_t frames() const = 0;

  /// The newest experience of the graph was created where the robot is; the first one where the map starts.
  /// @param geometry where a template was recalled there, else null. @return the robot's place from now on.
  virtual RobotPlace create(const ExperienceGraph& graph, const RobotPlace& robot,
                            const RecallGeometry* geometry) = 0;

  /// The robot recognised an experience. @param relative_rad heading now relative to that of the experience
  /// [rad].
  virtual RobotPlace recall(const ExperienceGraph& graph, std::uint32_t experience, const RobotPlace& robot,
                            double relative_rad, const RecallGeometry* geometry) = 0;

  /// Gives the robot a frame of its own where it is, so that what follows can be mended apart from what was
  /// before. @return its place from now on; the old one where the solver knows no such frames.
  virtual RobotPlace anchor(const ExperienceGraph&, const RobotPlace& robot) { return robot; }

  /// Covariance of the robot's pose (x, y, z, yaw) in the map, whose first place is exact; none where the solver
  /// knows none.
  virtual std::optional<Eigen::Matrix4d> covariance(const RobotPlace&) const { return std::nullopt; }

  /// Whether it can take in what a stretch of the way was after all.
  virtual bool corrects() const { return false; }
  virtual void correct(ExperienceGraph&, const CorrectedWay&) {}

  /// Works on the poses after an action; a bounded amount of work.
  virtual void update(ExperienceGraph& graph, RobotPlace& robot) = 0;

  /// Goes on with work left over from earlier updates; a bounded amount of work.
  virtual void resume(ExperienceGraph& graph) = 0;

  /// Finishes all work left over.
  virtual void settle(ExperienceGraph& graph) = 0;

  /// What the solver knows beside the graph, work in progress included: a solver that is loaded goes on as
  /// the saved one would have.
  virtual void save(State& state) const = 0;
  /// @throws std::runtime_error naming what is missing or does not fit
  virtual void load(const State& state) = 0;
};

}  // namespace ratslam
