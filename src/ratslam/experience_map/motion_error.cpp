#include "ratslam/experience_map/motion_error.h"

#include <cmath>

namespace ratslam {
namespace {

/// Standard deviation of the log-scale of a new unit that is not anchored.
constexpr double kUnknownScale = 1.0;

}  // namespace

void MotionError::add(const OdometryStep& step, double cos_yaw, double sin_yaw, double way) {
  // An error of the heading before or during the step turns the step's displacement about its start.
  const double dx = cos_yaw * step.forward - sin_yaw * step.left;
  const double dy = sin_yaw * step.forward + cos_yaw * step.left;
  covariance.row(0) -= dy * covariance.row(3);
  covariance.row(1) += dx * covariance.row(3);
  covariance.col(0) -= dy * covariance.col(3);
  covariance.col(1) += dx * covariance.col(3);
  if (step.covariance) {
    Eigen::Matrix4d by_step = Eigen::Matrix4d::Identity();
    by_step.topLeftCorner<2, 2>() << cos_yaw, -sin_yaw, sin_yaw, cos_yaw;
    by_step(0, 3) = -dy;
    by_step(1, 3) = dx;
    covariance += by_step * *step.covariance * by_step.transpose();
    said_length += way;
  }
  length += way;

  const UnitOfLength* unit = step.unit ? &*step.unit : nullptr;
  const double anchor = unit != nullptr ? unit->anchor_sigma.value_or(kUnknownScale) : kUnknownScale;
  if (step.new_unit) {
    scale_kept = 0.0;
    scale_variance = anchor * anchor;
    said_scale_length = length - way;
  }
  if (unit == nullptr) return;
  said_scale_length += way;
  const double come = unit->walk_sigma * unit->walk_sigma * way;
  if (!unit->anchor_sigma) {
    scale_variance += come;
    return;
  }
  const double kept = come > 0.0 ? std::exp(-come / (2.0 * anchor * anchor)) : 1.0;
  scale_kept *= kept;
  scale_variance = kept * kept * scale_variance + (1.0 - kept * kept) * anchor * anchor;
}

}  // namespace ratslam
