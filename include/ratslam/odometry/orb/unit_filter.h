/// Kalman filter of the error of the log of the odometry's unit of length.
///
/// The error is a random walk along the way. A measurement is log(target height / measured height). Patches of road
/// near each other share their errors, so a measurement has only the information of the road that no earlier one
/// showed.
///
/// A measurement far from the prediction (a kerb, a crossing street) is left out. If none has been used over two pieces
/// of road and the outliers agree, the unit has changed, as in a sharp turn with few landmarks, and the filter takes
/// their median. If they go on for long and do not agree, it is lost.
///
/// The walk is learned from the corrections (innovations of an optimal filter are as large as the walk), and the
/// roughness of the road from the innovations.
#pragma once

#include <deque>

namespace ratslam {

struct UnitFilterParams {
  /// Standard deviation of the log of the unit at the start, from planes ahead alone.
  double start_sigma = 0.05;
  double correlated = 4.0;  ///< length over which patches show the same piece of road [heights]
  double gate = 9.0;        ///< squared innovation of an outlier [sigma^2]
};

class UnitFilter {
 public:
  explicit UnitFilter(const UnitFilterParams& params = {}) : params_(params) {}

  /// Begins with a new unit. What has been learned about walk and road stays. @param height of the camera [unit]
  void start(double height);
  /// Moves on by a piece of way [unit].
  void move(double way);
  /// Uses a measurement. The first ones after the start are collected, and their median is used.
  /// @param log_error log(target height / measured height); @param variance of log_error
  /// @return log of the factor by which the unit is to be corrected; 0 if it is not
  double use(double log_error, double variance);

  /// Whether the first measurements after the start are still collected.
  bool starting() const { return starting_; }
  /// Whether the measurements contradict the unit and each other. Then it is to be measured anew.
  bool lost() const { return lost_; }
  /// Whether a measurement is near the prediction.
  bool expects(double log_error, double variance) const;
  /// Way since the last measurement that was used [unit].
  double unseen() const { return unseen_; }
  /// Standard deviation of the log of the unit.
  double sigma() const;
  /// Variance of the walk over one unit of way.
  double walkVariance() const;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("height", height_);
    fields("starting", starting_);
    fields("lost", lost_);
    fields("collected", collected_);
    fields("variance", variance_);
    fields("surprise", surprise_);
    fields("unseen", unseen_);
    fields("doubted", doubted_);
    fields("block_way", block_way_);
    fields("block_correction", block_correction_);
    fields("blocks_way", blocks_way_);
    fields("blocks_squares", blocks_squares_);
  }

 private:
  double predictedVariance() const { return variance_ + walkVariance() * unseen_; }
  double doubt(double log_error, double variance);
  double take(double log_error, double variance);
  double finishStart();

  UnitFilterParams params_;
  double height_ = 1.0;
  bool starting_ = true;
  bool lost_ = false;
  std::deque<double> collected_;  // first log errors, or the latest outliers
  double variance_ = 0.0;         // at the last measurement that was used
  double surprise_ = 1.0;         // mean square of the innovations / their expected variance
  double unseen_ = 0.0;
  double doubted_ = 0.0;    // way since the first of the latest outliers
  double block_way_ = 0.0;  // length of the present block, over which corrections are summed
  double block_correction_ = 0.0;
  double blocks_way_ = 0.0;  // length of all blocks
  double blocks_squares_ = 0.0;
};

}  // namespace ratslam
