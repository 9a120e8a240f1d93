/// Standard deviation of the robot's distance from a place that it recalls. It is learned, so that a car, a train
/// and a robot of a hand's size need no tuning.
///
/// 1. First guess. A new template is learned when the view has changed too much. So the distance between
///    templates shows from how far away a place can still be recalled: at most 4/3 of the median distance between
///    created experiences. That is the first guess of the spread, along and across the heading.
/// 2. Learning. The residuals at the optimum of the recalls that agree with the map give the spread as 1.4826
///    times the median of their sizes. The first guess is averaged in as if it were ten recalls. The spread is at
///    least spacing / sqrt(12): that of a place anywhere between two templates.
/// 3. Correlation. Neighbouring recalls share much of their errors. The correlation r of the errors is taken to fall
///    exponentially with the distance between the recalls (first-order autoregression), over a length that is
///    learned from the residuals if nearly all recalls agree. A recall at that distance has (1 - r) / (1 + r) of the
///    information of an independent one about an error they share; its weight is reduced accordingly.
/// No recall gets a larger standard deviation than the first guess: larger residuals are errors of the odometry, whose
/// residuals are correlated, too.
#pragma once

#include <vector>

#include "ratslam/experience_map/solver/pose_graph.h"

namespace ratslam {

class RecallSpread {
 public:
  /// @param place  fixed spread of the place [m]; 0: learned   @param facing  first guess for the heading [rad]
  RecallSpread(double place, double facing);

  /// Adds the length of the path from one created experience to the next [m].
  void addSpacing(double length);

  /// Size of a place [m]: the unit in which pose_graph_map.cpp states other lengths.
  double place() const { return fixed_ ? first_place_ : spacing_; }

  /// Sets the weights of a recall without image geometry. Its `apart` must be known.
  void weigh(Constraint& recall) const;

  /// Learns from the residuals of a graph at its optimum, if there are enough new recalls.
  /// @return whether recalls are to be weighed anew
  bool learn(const PoseGraph& graph);

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("spacings", spacings_);
    fields("spacing", spacing_);
    fields("counted_at", counted_at_);
    fields("learned_at", learned_at_);
    fields("along", along_);
    fields("across", across_);
    fields("up", up_);
    fields("facing", facing_);
  }

 private:
  /// What has been learned of one component of the errors.
  struct Component {
    double sigma = 0.0;       ///< standard deviation, with the first guess averaged in; 0: not learned yet
    double shown = 0.0;       ///< standard deviation by the residuals alone
    double correlated = 0.0;  ///< length over which the correlation falls to 1/e [m]; 0: independent

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("sigma", sigma);
      fields("shown", shown);
      fields("correlated", correlated);
    }

    /// Standard deviation that gives a recall its weight. @param apart distance from the recall before it [m]
    double effective(double guess, double apart) const;
    /// @param errors of the recalls in their order, with their distances `apart`
    /// @return whether the values have changed noticeably
    bool learn(double guess, double least, const std::vector<double>& errors,
               const std::vector<double>& apart, double near);
  };

  bool fixed_;
  double first_place_;
  double first_facing_;
  std::vector<double> spacings_;
  double spacing_ = 1.0;
  std::uint64_t counted_at_ = 0;  ///< number of spacings at the last median
  std::uint64_t learned_at_ = 0;  ///< number of recalls at the last call of learn() that used them
  Component along_;
  Component across_;
  Component up_;
  Component facing_;
};

}  // namespace ratslam
