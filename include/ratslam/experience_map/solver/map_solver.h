/// Interface between ExperienceMap and its solvers. A solver places the robot when an experience is created or
/// recalled, and keeps the poses of the map consistent with the measurements.
///
/// A solver expresses poses in frames. relaxation.h has one frame for each experience. pose_graph_map.h adds
/// frames for recalls, because at a recall the robot is not exactly where it was when the experience was made.
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

/// Place of the robot: a frame and the motion since the robot was last placed in it, or beside it (standing.h).
struct RobotPlace {
  std::uint32_t frame = 0;
  Motion motion;      ///< motion.pose is in the frame; motion.error began when the robot was placed
  bool lost = false;  ///< the motion from there to the present place was not measured
  Standing standing{};

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("frame", frame);
    fields("motion", motion);
    fields("lost", lost);
    fields("standing", standing);
  }
};

/// A later measurement of a stretch of the robot's path.
struct CorrectedWay {
  std::uint32_t from = 0;  ///< frame in which the stretch begins
  RelativePose before;     ///< pose of the robot in that frame at the beginning
  /// Frames made since, with their poses in the axes of the robot at the beginning, in the order of the path.
  std::vector<std::pair<std::uint32_t, RelativePose>> frames;
  std::size_t within = 0;  ///< number of these frames that lie within the stretch
  /// Covariance (x, y, z, yaw) of the last frame within the stretch.
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

  /// Places the newest experience of the graph at the robot, and the first one where the map starts.
  /// @param geometry of the known template that was recalled there, or null. @return the robot's new place.
  virtual RobotPlace create(const ExperienceGraph& graph, const RobotPlace& robot,
                            const RecallGeometry* geometry) = 0;

  /// Places the robot at a recalled experience. @param relative_rad heading now relative to that of the
  /// experience [rad]. @param geometry of its template, or null. @return the robot's new place; none if the recall
  /// is ignored.
  virtual std::optional<RobotPlace> recall(const ExperienceGraph& graph, std::uint32_t experience,
                                           const RobotPlace& robot, double relative_rad,
                                           const RecallGeometry* geometry) = 0;

  /// Place of the robot at a recalled experience of a map that may not change. The parameters are those of recall().
  virtual RobotPlace locate(std::uint32_t experience, double relative_rad, const RecallGeometry* geometry) {
    RobotPlace found{frameOf(experience), Motion{}};
    found.motion.pose.yaw = wrapAngle(relative_rad);
    if (geometry != nullptr) found.motion.pose.x = geometry->ahead;
    return found;
  }

  /// Makes a frame at the robot, so that the motion from here on can be corrected apart from the motion before.
  /// @return the robot's new place; the old one if the solver makes no such frames.
  virtual RobotPlace anchor(const ExperienceGraph&, const RobotPlace& robot) { return robot; }

  /// Covariance of the robot's pose (x, y, z, yaw) relative to the first experience; none if the solver has none.
  virtual std::optional<Eigen::Matrix4d> covariance(const RobotPlace&) const { return std::nullopt; }

  /// Whether the solver can use a later measurement of a stretch of the path.
  virtual bool corrects() const { return false; }
  virtual void correct(ExperienceGraph&, const CorrectedWay&) {}

  /// Improves the poses after an action, by a bounded amount of work.
  virtual void update(ExperienceGraph& graph, RobotPlace& robot) = 0;

  /// Continues the work that earlier updates left, by a bounded amount.
  virtual void resume(ExperienceGraph& graph) = 0;

  /// Finishes all remaining work.
  virtual void settle(ExperienceGraph& graph) = 0;

  /// Saves everything that does not follow from the graph, including work in progress: a loaded solver continues
  /// exactly as the saved one would have.
  virtual void save(State& state) const = 0;
  /// @throws std::runtime_error naming what is missing or does not fit
  virtual void load(const State& state) = 0;
};

}  // namespace ratslam
