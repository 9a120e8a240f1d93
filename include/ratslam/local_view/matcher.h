/// Search among learned views: the other half of the seam that descriptor.h begins.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ratslam/local_view/descriptor.h"

namespace ratslam {

/// The learned view most like a view.
struct ViewMatch {
  std::uint32_t id = 0;
  double relative_rad = 0.0;  ///< heading now relative to the heading when it was learned [rad]
  double error = 0.0;         ///< 0 for the same view, in the matcher's own measure
  bool same_place = false;    ///< the error is small enough to take both for views of one place
};

/// How like a view each learned view is: one row for each direction or shift of comparison.
struct ViewLikeness {
  std::size_t variants = 0;
  std::size_t places = 0;
  std::vector<float> values;   ///< variants x places, row by row; more is more alike
  std::vector<double> priors;  ///< how likely each variant is, before anything is known; they sum to 1

  const float* row(std::size_t variant) const { return values.data() + variant * places; }
};

class ViewMatcher {
 public:
  ViewMatcher() = default;
  ViewMatcher(const ViewMatcher&) = delete;
  ViewMatcher& operator=(const ViewMatcher&) = delete;
  virtual ~ViewMatcher();

  /// Learns a view. Its id is the number of views learned before.
  virtual std::uint32_t add(const View& view) = 0;
  virtual std::size_t size() const = 0;

  /// The learned view of the smallest error, of equals the lowest id; none where none is a candidate.
  virtual std::optional<ViewMatch> findBest(const View& view) = 0;

  /// The same measure of learned view `id` alone, at variant 0. @throws std::out_of_range.
  virtual ViewMatch compareWith(const View& view, std::uint32_t id) = 0;

  /// Learned view `id` as a view that can be compared, and learned elsewhere. @throws std::out_of_range.
  virtual View learned(std::uint32_t id) const = 0;

  /// All learned views against all variants of a view, or against the one that the matcher has for all.
  virtual void compareAll(const View& view, ViewLikeness& likeness) = 0;

  /// How much of a view the one before it did not tell: 0 for the same view, 1 for another one.
  virtual double novelty(const View& view, const View& before) const = 0;

  /// Pictures that a person can read, of equal size, 8-bit mono: of learned view `id`, and of a view.
  virtual cv::Mat picture(std::uint32_t id) const = 0;
  virtual cv::Mat picture(const View& view) const = 0;

  /// Memory held for the learned views.
  virtual std::size_t memoryBytes() const = 0;

  virtual void save(State& state) const = 0;
  /// @throws std::runtime_error naming what is missing or does not fit.
  virtual void load(const State& state) = 0;
};

}  // namespace ratslam
