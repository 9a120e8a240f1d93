/// Slow adaptation of each value of a descriptor to its usual mean and variance in the session. What all views have in
/// common (season, lens, bonnet of the car) does not distinguish places.
///
///     x' = (x - m) / sqrt(v), with m and v from before the view;
///     alpha = 1 / max(50, min(t + 1, 300)); d = x - m; m += alpha d; v = (1 - alpha) (v + alpha d^2)
///
/// At the first view m is that view's mean over all values of the same bin, and v the variance about it. So the first
/// views are compared as pictures without their mean.
#pragma once

#include <cstdint>
#include <vector>

namespace ratslam {

class Adaptation {
 public:
  /// Values that share one mean and variance: the columns of a panorama, because a turn of the robot moves the same
  /// scene through all of them.
  struct Sharing {
    std::size_t count = 1;   ///< number of values that share
    std::size_t stride = 0;  ///< distance from one to the next [values]
  };

  /// @param bins number of consecutive values with different meanings; value i has the meaning of i % bins
  Adaptation(std::size_t values, std::size_t bins, Sharing sharing);

  /// The values normalised by the present adaptation.
  std::vector<double> apply(const std::vector<double>& values) const;

  /// Whether a first view has been seen; before that, apply() must not be called.
  bool started() const { return views_ > 0; }
  void start(const std::vector<double>& values);
  void learn(const std::vector<double>& values);

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("mean", mean_);
    fields("variance", variance_);
    fields("views", views_);
  }

 private:
  std::size_t bins_;
  Sharing sharing_;
  std::vector<double> mean_;
  std::vector<double> variance_;
  std::uint64_t views_ = 0;
};

}  // namespace ratslam
