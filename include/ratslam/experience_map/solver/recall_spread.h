/// How far the robot is from a place when it recalls it: learned, so that a car, a train and a robot of a hand's
/// size need no tuning.
///
/// Templates are learned anew once the view has changed too much; the way between them, the median of the ways
/// between created experiences, and a third more is how far the same place reaches at most. That is the spread
/// along and across the heading to begin with. Recalls that agree with the map then tell how much less it is:
/// the spread of their residuals at the optimum (1.4826 times the median of their sizes), joined with the first
/// guess as if that were ten recalls, and never below what the spacing alone allows (spacing / sqrt(12), a place
/// anywhere between two templates). What disagrees by more is the odometry's error, not the recall's.
#pragma once

#include <vector>

#include "ratslam/experience_map/solver/pose_graph.h"

namespace ratslam {

class RecallSpread {
 public:
  /// @param place  spread of the place [m], 0: learned   @param facing  of the heading, to begin with [rad]
  RecallSpread(double place, double facing);

  /// A way driven from one created experience to the next.
  void addSpacing(double length);

  /// About how far a place reaches, which other lengths are measured by [m].
  double place() const { return fixed_ ? first_place_ : spacing_; }

  /// Weighs a vague recall.
  void weigh(Constraint& recall) const;

  /// Learns from the residuals of a graph at its optimum where there are enough recalls more than the last time.
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
  bool fixed_;
  double first_place_;
  double first_facing_;
  std::vector<double> spacings_;
  double spacing_ = 1.0;
  std::uint64_t counted_at_ = 0;  ///< spacings when their median was last taken
  std::uint64_t learned_at_ = 0;  ///< recalls when their residuals were last looked at
  /// Standard deviations learned so far; 0: none yet.
  double along_ = 0.0;
  double across_ = 0.0;
  double up_ = 0.0;
  double facing_ = 0.0;
};

}  // namespace ratslam
