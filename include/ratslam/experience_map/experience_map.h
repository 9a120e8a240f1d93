/// The experience map: a graph of places that odometry and recalls keep consistent, the robot's pose in it,
/// its trajectory, and the way to a goal. Sources: equations (4) and (6); OpenRatSLAM; pose_graph.h for the
/// default solver.
///
/// Steps, at each stamp in this order:
///  1. integrate(): odometry is accumulated relative to where the robot was last placed in the map;
///  2. apply(): the pose cells' decision creates or recalls an experience, links it to the one
///     the robot came from, and the solver works on the map - relaxation (6), or the weighted
///     graph;
///  3. robotPose() is the pose of the robot's frame (+) odometry since.
/// Work that one update may not hold up is spread over the following ones; settle() finishes it.
///
/// exp_solver relaxation is OpenRatSLAM's map in the reference arithmetic of docs/model.md, including its sign of
/// relative_rad in links (facing = odometry + relative_rad). The graph solver takes relative_rad as events.h
/// defines it: heading now minus that of the destination.
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

  /// Sets the clock: the first odometry message, or the first after time has jumped. Time that passed on the
  /// old clock stays counted, the jump is not; how the robot got across it is unknown, so that the next
  /// experience, new or recalled, is not linked to the one before.
  void start(Stamp stamp);

  /// Motion from the newest stamp up to `end`. Only the stamps measure time; step.dt is not used.
  /// @throws std::invalid_argument where the clock is not set, time runs backwards or a number is not finite;
  /// the map is then as before.
  void integrate(Stamp end, const OdometryStep& step);

  /// A decision of the pose cells, after all odometry up to its stamp. The link starts at the experience that
  /// is current here, since odometry has been accumulated from there.
  /// @param geometry where image geometry measured the recall: of the recalled experience, or of the known
  /// template at whose recall a new experience was created; null otherwise.
  /// @throws std::invalid_argument where an experience does not exist, the new one is not the next number,
  /// the recalled one is current already, or a number is not finite; the map is then as before.
  void apply(const TopologicalAction& action, const RecallGeometry* geometry = nullptr);

  /// What a stretch of the way was after all, known at the newest stamp: takes the place of what integrate()
  /// was told of it. Left out where the map has no pose at its ends.
  /// @throws std::invalid_argument where a number is not finite; the map is then as before.
  void correct(const OdometryCorrection& correction);

  /// Finishes the work on the map that updates have left over. The newest online pose stays what it was.
  void settle();

  /// Pose in the map: x, y, z [m], yaw [rad], log-scale of the odometry.
  MapPose robotPose() const;

  /// Covariance of robotPose() (x, y, z, yaw), the first place of the map being exact: odometry and recalls as
  /// they say, at the optimum last reached. None before the first place, and with exp_solver relaxation.
  std::optional<Eigen::Matrix4d> robotCovariance() const;

  bool withHeight() const { return params_.exp_height; }

  /// The robot's attitude but for its yaw, as the odometry knows it.
  const Eigen::Quaterniond& robotTilt() const { return tilt_; }

  const ExperienceGraph& graph() const { return graph_; }

  /// Frame of an experience, as the samples of the trajectory name it.
  std::uint32_t frameOf(std::uint32_t experience) const { return solver_->frameOf(experience); }

  /// Frames that the solver keeps: one an experience, and with exp_solver graph those of recalls.
  std::size_t frames() const { return solver_->frames(); }

  /// Experience where the robot is, none before the first.
  std::optional<std::uint32_t> currentExperience() const { return current_; }

  /// Grows with every change of what graph() holds.
  std::uint64_t revision() const { return graph_.revision(); }

  /// The path as it was known at the time, one pose for each stamp.
  const std::vector<StampedPose>& onlineTrajectory() const { return trajectory_.online(); }

  /// The same path as the present map sees it.
  std::vector<StampedPose> finalTrajectory() const;

  /// Asks for the way to a place. @param x, y [m] in the map. @return whether there is one, and if not why.
  const Goal& setGoal(double x, double y);

  const Goal& goal() const { return planner_.goal(); }

  /// From the robot to the goal: the robot's pose, then the experiences on the way; empty unless a goal is
  /// active or has been reached.
  std::vector<MapPose> pathToGoal() const;

  /// Whether actions change the map; else recalls only place the robot in it, and no experience is created.
  void setLearning(bool learning) { learning_ = learning; }
  bool learning() const { return learning_; }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit
  void load(const State& state);

 private:
  void checkAction(const TopologicalAction& action, const RecallGeometry* geometry) const;
  /// Whether something was recognised. Else a known place becomes the current one (kSetNode) by what odometry has
  /// told already, unless the solver knows of nothing else.
  bool tellsPlace(const TopologicalAction& action) const;
  /// Where the solver has placed the robot.
  void place(const RobotPlace& placed);
  void create(const RecallGeometry* geometry);
  /// Places the robot at the recalled experience without a change of the map.
  void locate(const TopologicalAction& action, const RecallGeometry* geometry);
  void recall(const TopologicalAction& action, const RecallGeometry* geometry);
  Link measuredLink(std::uint32_t to, double relative_rad) const;
  MapPose framePose(std::uint32_t frame) const;
  void record();

  ExperienceMapParams params_;
  bool learning_ = true;
  ExperienceGraph graph_;
  std::unique_ptr<MapSolver> solver_;
  Trajectory trajectory_;
  GoalPlanner planner_;
  MapPose origin_;  ///< where the odometry starts
  RobotPlace robot_;
  Eigen::Quaterniond tilt_ = Eigen::Quaterniond::Identity();
  std::optional<std::uint32_t> current_;
  std::optional<Stamp> clock_;
  Stamp current_since_ = 0;
};

}  // namespace ratslam
