/// The drive that a map keeps, for replaying it through another map (map_merge.h).
///
/// At each pose of the map's path:
///
///  - The view that was seen there: of the experience that was created there, or that the recall there recognised.
///    Where a frame holds neither (the odometry predicted, or the camera saw nothing), and farther from the frame than
///    the pose cells take for one place, no view is known.
///  - Whether the motion from the pose before is known. It is not between sessions, and where the map was lost.
///  - The errors of that motion, from the constraint of the map's graph over the stretch. They grow with the way. An
///    unmeasured stretch may have no length in the map, as after a silence of the odometry: then they grow with time.
#pragma once

#include <optional>
#include <vector>

#include "ratslam/experience_map/experience_map.h"
#include "ratslam/experience_map/solver/pose_graph.h"
#include "ratslam/odometry/odometry.h"

namespace ratslam {

/// Errors of a stretch of a map's path. Only one of the two rates differs from 0.
struct KnownErrors {
  Eigen::Matrix4d variance_per_metre = Eigen::Matrix4d::Zero();   ///< of x, y, z, yaw
  Eigen::Matrix4d variance_per_second = Eigen::Matrix4d::Zero();  ///< of x, y, z, yaw
  UnitOfLength unit;

  bool growWithTime() const { return variance_per_second(3, 3) > 0.0; }
  /// Covariance of the twist of a step. @param forward [m]  @param seconds of the step
  TwistCovariance ofTwist(double forward, double seconds) const;
};

class KeptDrive {
 public:
  /// @param saved   the State of the map
  /// @param breaks  ends of the sessions after which another place may follow
  /// @param reach   how far a view is seen from the frame where it was recognised [m]
  KeptDrive(const ExperienceMap& map, const State& saved, std::vector<Stamp> breaks, double reach);

  const std::vector<StampedPose>& path() const { return path_; }
  /// The experience whose view was seen at a pose; none if no view is known there.
  std::optional<std::uint32_t> seenAt(std::size_t pose) const { return seen_[pose]; }
  /// Errors of the motion from the pose before; none if the map has none.
  const std::optional<KnownErrors>& errors(std::size_t pose) const { return errors_[pose]; }
  /// Whether the motion from the pose before to pose `next` is known.
  bool goesOn(std::size_t next) const;

 private:
  using Constraints = std::vector<Constraint>;

  void findViews(const ExperienceMap& map, const Trajectory& trajectory, const Constraints& constraints,
                 double reach);
  void readErrors(const Trajectory& trajectory, const Constraints& constraints);
  std::optional<KnownErrors> errorsOf(const Constraint& way, std::size_t first, std::size_t last) const;

  std::vector<StampedPose> path_;
  std::vector<std::uint32_t> component_;  ///< of the map at each pose
  std::vector<std::optional<std::uint32_t>> seen_;
  std::vector<std::optional<KnownErrors>> errors_;
  std::vector<bool> lost_;  ///< whether the motion from the pose before was not measured
  std::vector<Stamp> breaks_;
};

/// Component of each experience. A component has the number of its first experience.
std::vector<std::uint32_t> componentsOf(const ExperienceGraph& graph);

/// Forward motion and turn from one pose of a path to the next [m, rad].
struct DrivenStep {
  double forward = 0.0;
  double rotation = 0.0;
};
DrivenStep drivenBetween(const StampedPose& from, const StampedPose& to);

/// Number of steps into which a step of a thinned path is divided if it takes so long.
int sharesOf(double seconds);

}  // namespace ratslam
