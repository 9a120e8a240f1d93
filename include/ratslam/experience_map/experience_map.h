/// The experience map: a graph of experiences, the robot's pose in it, its trajectory, and the path to a goal.
/// Sources: equations (4) and (6); OpenRatSLAM; pose_graph.h for the default solver.
///
/// Steps, at each stamp in this order:
///  1. integrate() accumulates odometry relative to where the robot was last placed in the map.
///  2. apply() carries out the pose cells' decision. It creates or recalls an experience and links it to the
///     current one. Then the solver corrects the map: relaxation (6), or the weighted graph.
///  3. robotPose() composes the pose of the robot's frame with the odometry since.
/// The solver does a bounded amount of work at an update; later updates continue it, and settle() finishes it.
///
/// exp_solver relaxation is OpenRatSLAM's map in the reference arithmetic of docs/model.md. It keeps
/// OpenRatSLAM's sign of relative_rad in links: facing = odometry + relative_rad. The graph solver takes
/// relative_rad as events.h defines it: heading now minus the heading of the destination.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ratslam/events.h"
#include "ratslam/experience_map/experience_graph.h"
#include "ratslam/experience_map/goal_planner.h"
#include "ratslam/experience_map/params.h"
#include "ratslam/experience_map/solver/map_solver.h"
#include "ratslam/experience_map/trajectory.h"

namespace ratslam {

class ExperienceMap {
 public:
  /// @throws std::invalid_argument naming key, value and requirement.
  explicit ExperienceMap(const ExperienceMapParams& params);

  /// Sets the clock, at the first odometry message and at the first one after time has jumped. Durations count
  /// the time before the jump, but not the jump. The robot's motion during the jump is unknown: so the next
  /// experience, new or recalled, is not linked to the current one.
  void start(Stamp stamp);

  /// Adds the motion from the newest stamp to `end`. Time is measured by the stamps; step.dt is not used.
  /// @throws std::invalid_argument if the clock is not set, time runs backwards or a number is not finite.
  /// The map is then unchanged.
  void integrate(Stamp end, const OdometryStep& step);

  /// Carries out a decision of the pose cells. All odometry up to its stamp must have been integrated. A link
  /// starts at the map's current experience, because odometry has been accumulated from there.
  /// @param geometry the recall as image geometry measured it, or null: relative to the template of the recalled
  /// experience, or, for a new experience, to the known template that was recalled when it was created.
  /// @throws std::invalid_argument if an experience does not exist, a new one does not have the next number, a
  /// recalled one is the current one, or a number is not finite. The map is then unchanged.
  void apply(const TopologicalAction& action, const RecallGeometry* geometry = nullptr);

  /// Replaces the motion that integrate() received for a stretch of the path by a later measurement of it.
  /// Does nothing if the map has no pose at the ends of the stretch.
  /// @throws std::invalid_argument if a number is not finite. The map is then unchanged.
  void correct(const OdometryCorrection& correction);

  /// Finishes the solver's remaining work. The newest pose of the online trajectory does not change.
  void settle();
  /// A copy with the solver's work finished. This map goes on as it was.
  std::unique_ptr<ExperienceMap> settled() const;

  /// A step of the odometry in the unit of length of the robot's frame, level unless the map has height.
  OdometryStep inRobotsUnit(const OdometryStep& step) const;

  /// Pose in the map: x, y, z [m], yaw [rad], log-scale of the odometry.
  MapPose robotPose() const;

  /// Covariance of robotPose() (x, y, z, yaw) relative to the first experience [m, rad]: it follows from the
  /// covariances of odometry and recalls at the last optimum of the solver, and from unitSigma(). None before the
  /// first experience and with exp_solver relaxation.
  std::optional<Eigen::Matrix4d> robotCovariance() const;

  /// Relative standard deviation of the map's metre: the greatest UnitOfLength::constant_sigma so far.
  double unitSigma() const { return unit_sigma_; }

  bool withHeight() const { return params_.exp_height; }

  /// The robot's attitude without its yaw, from the odometry.
  const Eigen::Quaterniond& robotTilt() const { return tilt_; }

  const ExperienceGraph& graph() const { return graph_; }

  /// Frame of an experience, in the numbering of the trajectory's samples.
  std::uint32_t frameOf(std::uint32_t experience) const { return solver_->frameOf(experience); }

  /// Number of frames: one for each experience, and with exp_solver graph also those of recalls.
  std::size_t frames() const { return solver_->frames(); }

  /// Current experience; none before the first.
  std::optional<std::uint32_t> currentExperience() const { return current_; }

  /// Grows with every change of what graph() holds.
  std::uint64_t revision() const { return graph_.revision(); }

  /// The robot's path as it was estimated at the time, one pose for each stamp.
  const std::vector<StampedPose>& onlineTrajectory() const { return trajectory_.online(); }

  /// The same path in the present map.
  std::vector<StampedPose> finalTrajectory() const;

  /// Plans a path to a goal. @param x, y [m] in the map. @return the goal with its status; if there is no path,
  /// its message says why.
  const Goal& setGoal(double x, double y);

  /// Ends the way to a goal.
  void dropGoal() { planner_ = GoalPlanner(params_.exp_goal_radius, params_.exp_goal_timeout); }
  const Goal& goal() const { return planner_.goal(); }

  /// The robot's pose, then the experiences on the path to the goal. Empty unless a goal is active or reached.
  std::vector<MapPose> pathToGoal() const;

  /// Whether actions change the map. If not, recalls only place the robot in it, and no experience is created.
  void setLearning(bool learning) { learning_ = learning; }
  bool learning() const { return learning_; }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit
  void load(const State& state);

 private:
  void checkAction(const TopologicalAction& action, const RecallGeometry* geometry) const;
  /// Whether an action places the robot. kSetNode adds no evidence of its place: it follows from odometry, which
  /// has been integrated already. It counts only if the robot is lost or the solver has nothing else to use.
  bool tellsPlace(const TopologicalAction& action) const;
  /// Takes over the place that the solver has given to the robot.
  void place(const RobotPlace& placed);
  /// Sets the time of the latest decision that the map has used.
  void stayFrom(Stamp stamp);
  void reach(std::uint32_t experience);
  void create(const RecallGeometry* geometry);
  /// Places the robot at the recalled experience without changing the map.
  void locate(const TopologicalAction& action, const RecallGeometry* geometry);
  void recall(const TopologicalAction& action, const RecallGeometry* geometry);
  Link measuredLink(std::uint32_t to, double relative_rad) const;
  MapPose framePose(std::uint32_t frame) const;
  void record();

  ExperienceMapParams params_;
  bool learning_ = true;
  std::uint64_t bridged_steps_ = 0;  ///< predicted steps of the odometry in a row
  ExperienceGraph graph_;
  std::unique_ptr<MapSolver> solver_;
  Trajectory trajectory_;
  GoalPlanner planner_;
  MapPose origin_;  ///< where the odometry starts
  RobotPlace robot_;
  Eigen::Quaterniond tilt_ = Eigen::Quaterniond::Identity();
  std::optional<std::uint32_t> current_;
  std::optional<Stamp> clock_;
  /// The experience where the pose cells believe the robot is, after a recall that the map has ignored.
  std::optional<std::uint32_t> ignored_;
  Stamp current_since_ = 0;
  Stamp stood_ns_ = 0;  ///< how long the robot has stood still since
  double unit_sigma_ = 0.0;
};

}  // namespace ratslam
