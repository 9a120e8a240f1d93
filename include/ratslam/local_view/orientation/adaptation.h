/// Slow adaptation of each value of a descriptor to what the session usually sees there: what is common to
/// all views of a season, a lens or a bonnet says nothing about the place.
///
///     x' = (x - m) / sqrt(v), with m and v from before the view;
///     alpha = 1 / max(50, min(t + 1, 300)); d = x - m; m += alpha d; v = (1 - alpha) (v + alpha d^2)
///
/// Nothing is known before the first view: m begins as that view's mean over all values of the same bin, v as
/// the variance about it, so that the first views are compared as pictures with a mean taken off.
#pragma once

#include <cstdint>
#include <vector>

namespace ratslam {

class Adaptation {
 public:
  /// @param shared how many values apart those lie which adapt as one, and how many such there are: the
  /// columns of a panorama, through which a robot that turns moves the same scene.
  struct Sharing {
    std::size_t count = 1;
    std::size_t stride = 0;
  };

  /// @param bins values in a row that mean different things; all others of the same bin mean the same
  Adaptation(std::size_t values, std::size_t bins, Sharing sharing);

  /// Values seen with the present adaptation.
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
