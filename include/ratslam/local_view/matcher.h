/// Interface of view matchers: a matcher stores learned views and compares new ones with them (see descriptor.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ratslam/local_view/descriptor.h"

namespace ratslam {

/// The learned view most similar to a view.
struct ViewMatch {
  std::uint32_t id = 0;
  double relative_rad = 0.0;  ///< heading now relative to the heading when it was learned [rad]
  double error = 0.0;         ///< in the matcher's own measure; 0 for the same view
  bool same_place = false;    ///< the error is small enough for two views of one place
};

/// Similarity of a view to each learned view, with one row for each variant of the view.
struct ViewLikeness {
  std::size_t variants = 0;
  std::size_t places = 0;
  std::vector<float> values;   ///< variants x places, row by row; larger is more similar
  std::vector<double> priors;  ///< prior probability of each variant; they sum to 1

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

  /// The learned view with the smallest error, of equals the lowest id; none if there is no candidate.
  virtual std::optional<ViewMatch> findBest(const View& view) = 0;

  /// Comparison with learned view `id` alone, at variant 0. @throws std::out_of_range.
  virtual ViewMatch compareWith(const View& view, std::uint32_t id) = 0;

  /// Learned view `id`, which another matcher can compare and learn. @throws std::out_of_range.
  virtual View learned(std::uint32_t id) const = 0;

  /// Compares all learned views with all variants of a view. A matcher that shifts views itself has one variant.
  virtual void compareAll(const View& view, ViewLikeness& likeness) = 0;

  /// Novelty of a view relative to the one before: 0 for the same view, 1 for an independent one.
  virtual double novelty(const View& view, const View& before) const = 0;

  /// Pictures for display, of equal size, 8-bit mono: of learned view `id`, and of a view.
  virtual cv::Mat picture(std::uint32_t id) const = 0;
  virtual cv::Mat picture(const View& view) const = 0;

  /// Memory held for the learned views.
  virtual std::size_t memoryBytes() const = 0;

  virtual void save(State& state) const = 0;
  /// @throws std::runtime_error naming what is missing or does not fit.
  virtual void load(const State& state) = 0;
};

}  // namespace ratslam
