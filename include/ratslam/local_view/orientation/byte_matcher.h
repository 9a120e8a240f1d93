/// Matcher for vectors that are stored as bytes and compared by the cosine of their angle. It suits any descriptor
/// whose values have about mean 0 and deviation 1.
///
/// All learned vectors are compared, without shortcuts: one byte per value, whole-number products
/// (simd/byte_products.h), one division by the lengths.
#pragma once

#include <functional>
#include <memory>

#include "ratslam/local_view/matcher.h"
#include "ratslam/simd/byte_products.h"

namespace ratslam {

/// A vector in bytes: round(32 x), clamped to +-127.
struct ByteVector {
  std::vector<std::int8_t> values;
  float length = 0.0F;  ///< Euclidean
};

class ByteMatcher : public ViewMatcher {
 public:
  /// Draws a vector for display.
  using Painter = std::function<cv::Mat(const std::vector<std::int8_t>&)>;

  /// @param values of a vector @param same_place largest error (1 - cosine) of two views of one place
  /// @throws std::invalid_argument if a vector would be too long, or this processor lacks the level
  ByteMatcher(std::size_t values, double same_place, Painter painter, SimdLevel level = bestSimdLevel());

  std::uint32_t add(const View& view) override;
  std::size_t size() const override { return lengths_.size(); }
  std::optional<ViewMatch> findBest(const View& view) override;
  ViewMatch compareWith(const View& view, std::uint32_t id) override;
  View learned(std::uint32_t id) const override;
  void compareAll(const View& view, ViewLikeness& likeness) override;
  double novelty(const View& view, const View& before) const override;
  cv::Mat picture(std::uint32_t id) const override;
  cv::Mat picture(const View& view) const override;
  std::size_t memoryBytes() const override;
  void save(State& state) const override;
  void load(const State& state) override;

 private:
  /// A vector in a State.
  struct Row {
    std::vector<std::int8_t> values;

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("values", values);
    }
  };

  ByteVector padded(std::vector<std::int8_t> values) const;
  ByteVector bytesOf(const std::vector<double>& values) const;
  const std::uint8_t* vectorAt(std::size_t id) const;
  void append(const ByteVector& vector);
  std::vector<std::int8_t> valuesOf(std::uint32_t id) const;
  void setQueries(const View& view);
  void multiply(std::size_t first, std::size_t last, std::size_t queries, std::int32_t* products,
                std::size_t stride) const;

  std::size_t values_;
  std::size_t stride_;  // bytes from one vector to the next
  double same_place_;
  Painter painter_;
  ByteProducts products_;
  std::vector<std::unique_ptr<std::uint8_t[]>> segments_;  // never move, so adding costs O(1)
  std::vector<float> lengths_;
  std::vector<std::int8_t> queries_;  // of the present view
  std::vector<float> query_lengths_;
  std::vector<std::int32_t> products_of_segment_;
  ViewLikeness likeness_;
};

}  // namespace ratslam
