/// How the camera has moved of late, and how fast its motion changes: what is known of a stretch that nobody
/// measures.
///
/// Speed and turn rate are modelled as random walks. Their diffusions are learned from the measured motion,
/// as mean squares of what changed within about a second: a train changes slowly, a toy car fast, and no unit
/// of length needs to be known.
#pragma once

#include <deque>

#include "ratslam/common/stamp.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam {

/// A motion of the camera: its pose at the end in that at the start, and the covariance of (translation,
/// rotation) in the axes at the start.
struct UncertainMotion {
  RigidTransform motion;
  Matrix6 covariance = Matrix6::Zero();

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("motion", motion);
    fields("covariance", covariance);
  }
};

/// A turn of the camera: its axes at the end in those at the start, and the covariance in the latter [rad^2].
struct UncertainTurn {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

class MotionHistory {
 public:
  /// @param unknown_speed of a camera of which nothing has been measured yet.
  explicit MotionHistory(double unknown_speed) : unknown_speed_(unknown_speed) {}

  /// A measured twist of the camera, in its own axes (translation, rotation) per second, over the time that
  /// ends at `stamp`.
  void add(Stamp stamp, const Vector6& twist);
  bool empty() const { return recent_.empty(); }
  /// The mean twist of the last few measurements; zero where there are none.
  Vector6 twist() const;
  /// The unit of length has changed.
  void rescale(double factor);
  /// A jump in time or a fresh start: the measurements before say nothing of changes from now on.
  void interrupt() { recent_.clear(); }

  /// Growth of the variance of the speed [units^2/s^3] and of the turn rate [rad^2/s^3].
  double speedDiffusion() const;
  double turnDiffusion() const;

  /// Motion from `begin` to `end` seconds after the last measurement, predicted from before alone. Its
  /// covariances add up to that of the whole, though its errors are those of one and the same speed.
  UncertainMotion predict(double begin, double end) const;
  /// Variance [rad^2] of the turn over `duration` seconds that nobody measured, between two turn rates [rad/s]
  /// whose mean is taken for it. On a straight road little turns; who turns goes on turning for seconds, and
  /// nobody knows how many.
  static double turnVariance(const Eigen::Vector3d& before, const Eigen::Vector3d& after, double duration);
  /// Covariance of a motion along `way` whose length and turn about the vertical have these variances.
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
  double weight_ = 0.0;         // of what was learned [s]
  double speed_changes_ = 0.0;  // sums, weighted alike
  double turn_changes_ = 0.0;
};

}  // namespace ratslam
