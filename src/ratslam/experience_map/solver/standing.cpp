#include "ratslam/experience_map/solver/standing.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace ratslam {

Standing stand(const Prediction& predicted, const UncertainPose& seen, double log_scale) {
  // Selects (x, y, z, yaw) from (x, y, facing, log-scale, z).
  Eigen::Matrix<double, 4, 5> observed = Eigen::Matrix<double, 4, 5>::Zero();
  observed(0, 0) = observed(1, 1) = observed(2, 4) = observed(3, 2) = 1.0;
  const RelativePose& pose = predicted.pose;
  const Eigen::Vector4d news(seen.pose.x - pose.x, seen.pose.y - pose.y, seen.pose.z - pose.z,
                             wrapAngle(seen.pose.yaw - pose.yaw));
  const Eigen::Matrix<double, 4, 5> shared = observed * predicted.covariance;
  const Eigen::Matrix4d spread = shared * observed.transpose() + seen.covariance;
  const Eigen::Matrix<double, 4, 5> gain = spread.llt().solve(shared);  // transposed
  const Eigen::Matrix<double, 5, 1> moved = gain.transpose() * news;

  Standing standing;
  standing.beside = true;
  const double per_metre = std::exp(-log_scale);
  standing.at = {per_metre * (pose.x + moved[0]), per_metre * (pose.y + moved[1]),
                 per_metre * (pose.z + moved[4]), wrapAngle(pose.yaw + moved[2])};
  standing.covariance = predicted.covariance - gain.transpose() * shared;
  standing.covariance = 0.5 * (standing.covariance + standing.covariance.transpose()).eval();
  standing.log_unit = predicted.log_scale + moved[3] - log_scale;
  return standing;
}

}  // namespace ratslam
