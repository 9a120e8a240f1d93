/// The camera's recent motion and how fast it changes: a model for unmeasured stretches.
///
/// Speed and turn rate are random walks. Their diffusions are learned from the measured motion, as mean squares of
/// the change within about a second. So the model fits a slow train and a fast toy car, in any unit of length.
#pragma once

#include <deque>

#include "ratslam/common/stamp.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam {

/// A motion of the camera: its pose at the end relative to its pose at the start, and the covariance of
/// (translation, rotation) in the axes at the start.
struct UncertainMotion {
  RigidTransform motion;
  Matrix6 covariance = Matrix6::Zero();

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("motion", motion);
    fields("covariance", covariance);
  }
};

/// A turn of the camera: its axes at the end in those at the start, and the covariance in the axes at the start
/// [rad^2].
struct UncertainTurn {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

class MotionHistory {
 public:
  /// @param unknown_speed standard deviation of the speed before the first measurement.
  explicit MotionHistory(double unknown_speed) : unknown_speed_(unknown_speed) {}

  /// Adds a measured twist of the camera, in its own axes (translation, rotation) per second, over the time that
  /// ends at `stamp`.
  void add(Stamp stamp, const Vector6& twist);
  bool empty() const { return recent_.empty(); }
  /// The mean twist of the last few measurements; zero if there are none.
  Vector6 twist() const;
  /// Converts the history to a new unit of length.
  void rescale(double factor);
  /// To be called at a jump in time or a fresh start: no change is computed across it.
  void interrupt() { recent_.clear(); }

  /// Growth of the variance of the speed [units^2/s^3] and of the turn rate [rad^2/s^3].
  double speedDiffusion() const;
  double turnDiffusion() const;

  /// Predicted motion from `begin` to `end` seconds after the last measurement. The covariances of consecutive
  /// stretches add up to that of the whole, although their errors are correlated.
  UncertainMotion predict(double begin, double end) const;
  /// Variance [rad^2] of the turn over an unmeasured stretch of `duration` seconds, if it is estimated by the mean
  /// of the turn rates [rad/s] at both ends. It is small on a straight road. A turn in progress continues for an
  /// unknown number of seconds.
  static double turnVariance(const Eigen::Vector3d& before, const Eigen::Vector3d& after, double duration);
  /// Covariance of a motion by `way`, given the variances of its length and of its turn about the vertical.
  static Matrix6 spread(const Eigen::Vector3d& way, double speed_variance, double turn_variance);

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("recent", recent_);
    fields("weight", weight_);
    fields("speed_changes", speed_changes_);
    fields("turn_changes", turn_changes_);
  }

 private:
  struct Measurement {
    Stamp stamp = 0;
    Vector6 twist = Vector6::Zero();

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("twist", twist);
    }
  };
  UncertainMotion along(const Vector6& twist, double duration, double speed_variance,
                        double turn_variance) const;

  double unknown_speed_;
  std::deque<Measurement> recent_;
  double weight_ = 0.0;         // of the learned diffusions [s]
  double speed_changes_ = 0.0;  // sums with the same weights
  double turn_changes_ = 0.0;
};

}  // namespace ratslam
