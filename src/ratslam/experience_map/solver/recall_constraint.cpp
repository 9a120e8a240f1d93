// The constraint of a recall: the robot's pose relative to the experience, with weights.
#include <algorithm>
#include <cmath>

#include "ratslam/experience_map/solver/pose_graph_map.h"

namespace ratslam {
namespace {

/// Least standard deviation of a measured offset, beside its own error, as a share of exp_recall_sigma.
constexpr double kLateralShare = 0.1;

}  // namespace

Constraint PoseGraphMap::recallConstraint(std::uint32_t experience, double relative_rad,
                                          const RecallGeometry* geometry) const {
  const double place = spread_.place();
  Constraint constraint;
  constraint.recall = true;
  constraint.from = nodes_[experience];
  constraint.measured.yaw = wrapAngle(relative_rad);
  spread_.weigh(constraint);
  constraint.vague = geometry == nullptr || !geometry->measured();
  const TemplateOffset& offset = offsets_[experience];
  // Convert from the axes of the template to those of the experience, and from the odometry's unit to the map's.
  const Eigen::Rotation2Dd to_experience(-offset.rotation);
  const double unit = pose_graph_.nodes()[constraint.from].scale();
  if (constraint.vague) {
    if (!offset.displacement) return constraint;
    const Eigen::Vector2d now(geometry != nullptr ? geometry->ahead : 0.0, 0.0);
    const Eigen::Vector2d moved = unit * (to_experience * (now - *offset.displacement));
    constraint.measured.x = moved.x();
    constraint.measured.y = moved.y();
    return constraint;
  }
  constraint.measured.yaw = wrapAngle(geometry->relative_rad - offset.rotation);
  constraint.yaw_weight = 1.0 / geometry->sigma_rotation;
  if (!offset.displacement) return constraint;

  const Eigen::Vector2d along =
      to_experience * Eigen::Vector2d(std::cos(geometry->direction_rad), std::sin(geometry->direction_rad));
  const Eigen::Vector2d across(-along.y(), along.x());
  const double distance = unit * std::max(geometry->distance, 0.0);
  const Eigen::Vector2d measured = distance * along - unit * (to_experience * *offset.displacement);
  constraint.measured.x = measured.x();
  constraint.measured.y = measured.y();
  const bool measured_length = geometry->distance >= 0.0;
  const double sigma_along =
      measured_length ? std::hypot(kLateralShare * place, unit * geometry->sigma_distance) : place;
  const double sigma_across =
      std::hypot(kLateralShare * place, (measured_length ? distance : place) * geometry->sigma_direction);
  constraint.xy_weight.row(0) = along / std::min(sigma_along, place);
  constraint.xy_weight.row(1) = across / std::min(sigma_across, place);
  return constraint;
}

}  // namespace ratslam
