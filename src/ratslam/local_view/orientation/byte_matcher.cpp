#include "ratslam/local_view/orientation/byte_matcher.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr double kLevelsInOne = 32.0;  // 4 standard deviations are 128 levels
constexpr double kLargest = 127.0;
constexpr std::size_t kInSegment = 256;  // vectors per segment
constexpr std::uint8_t kBias = 128;

std::size_t rounded(std::size_t values) { return (values + kByteQuantum - 1) / kByteQuantum * kByteQuantum; }

}  // namespace

ByteMatcher::ByteMatcher(std::size_t values, double same_place, Painter painter, SimdLevel level)
    : values_(values),
      stride_(rounded(values)),
      same_place_(same_place),
      painter_(std::move(painter)),
      products_(byteProductsFor(level)) {
  if (values == 0 || stride_ > kLargestLength) {
    throw std::invalid_argument("view: a vector has " + std::to_string(values) + " values, not 1 to " +
                                std::to_string(kLargestLength));
  }
}

ByteVector ByteMatcher::bytesOf(const std::vector<double>& values) const {
  if (values.size() != values_) {
    throw std::invalid_argument("view: its vector has " + std::to_string(values.size()) + " values, not " +
                                std::to_string(values_));
  }
  std::vector<std::int8_t> bytes(values.size());
  std::transform(values.begin(), values.end(), bytes.begin(), [](double value) {
    return static_cast<std::int8_t>(std::floor(std::clamp(value * kLevelsInOne, -kLargest, kLargest) + 0.5));
  });
  return padded(std::move(bytes));
}

ByteVector ByteMatcher::padded(std::vector<std::int8_t> values) const {
  std::int32_t squares = 0;
  for (const std::int8_t value : values) squares += value * value;
  values.resize(stride_, 0);
  return {std::move(values), std::sqrt(static_cast<float>(std::max(squares, 1)))};
}

const std::uint8_t* ByteMatcher::vectorAt(std::size_t id) const {
  return segments_[id / kInSegment].get() + id % kInSegment * stride_;
}

void ByteMatcher::append(const ByteVector& vector) {
  const std::size_t id = size();
  if (id % kInSegment == 0) segments_.push_back(std::make_unique<std::uint8_t[]>(kInSegment * stride_));
  std::uint8_t* target = segments_.back().get() + id % kInSegment * stride_;
  std::transform(vector.values.begin(), vector.values.end(), target,
                 [](std::int8_t value) { return static_cast<std::uint8_t>(value + kBias); });
  lengths_.push_back(vector.length);
}

std::uint32_t ByteMatcher::add(const View& view) {
  append(bytesOf(view.variants.at(0).values));
  return static_cast<std::uint32_t>(size() - 1);
}

void ByteMatcher::setQueries(const View& view) {
  queries_.clear();
  query_lengths_.clear();
  for (const ViewVariant& variant : view.variants) {
    const ByteVector vector = bytesOf(variant.values);
    queries_.insert(queries_.end(), vector.values.begin(), vector.values.end());
    query_lengths_.push_back(vector.length);
  }
}

/// Products of the queries with the vectors [first, last), which must be in one segment.
void ByteMatcher::multiply(std::size_t first, std::size_t last, std::size_t queries, std::int32_t* products,
                           std::size_t stride) const {
  products_(vectorAt(first), last - first, stride_, queries_.data(), queries, products, stride);
}

void ByteMatcher::compareAll(const View& view, ViewLikeness& likeness) {
  setQueries(view);
  const std::size_t variants = query_lengths_.size();
  likeness.variants = variants;
  likeness.places = size();
  likeness.priors.clear();
  for (const ViewVariant& variant : view.variants) likeness.priors.push_back(variant.prior);
  likeness.values.resize(variants * size());
  products_of_segment_.resize(variants * kInSegment);
  for (std::size_t first = 0; first < size(); first += kInSegment) {
    const std::size_t last = std::min(first + kInSegment, size());
    multiply(first, last, variants, products_of_segment_.data(), kInSegment);
    for (std::size_t q = 0; q < variants; ++q) {
      const std::int32_t* products = products_of_segment_.data() + q * kInSegment;
      float* target = likeness.values.data() + q * size() + first;
      const float query_length = query_lengths_[q];
      for (std::size_t i = 0; i < last - first; ++i) {
        target[i] = static_cast<float>(products[i]) / (query_length * lengths_[first + i]);
      }
    }
  }
}

double ByteMatcher::novelty(const View& view, const View& before) const {
  const ByteVector a = bytesOf(view.variants.at(0).values);
  const ByteVector b = bytesOf(before.variants.at(0).values);
  std::int32_t product = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) product += a.values[i] * b.values[i];
  return std::clamp(1.0 - static_cast<double>(static_cast<float>(product) / (a.length * b.length)), 0.0, 1.0);
}

std::optional<ViewMatch> ByteMatcher::findBest(const View& view) {
  if (size() == 0) return std::nullopt;
  compareAll(view, likeness_);
  std::size_t best_place = 0;
  std::size_t best_variant = 0;
  for (std::size_t q = 0; q < likeness_.variants; ++q) {
    const float* row = likeness_.row(q);
    const auto place = static_cast<std::size_t>(std::max_element(row, row + likeness_.places) - row);
    const float best = likeness_.row(best_variant)[best_place];
    if (row[place] > best || (row[place] == best && place < best_place)) {
      best_place = place;
      best_variant = q;
    }
  }
  const double error = 1.0 - static_cast<double>(likeness_.row(best_variant)[best_place]);
  return ViewMatch{static_cast<std::uint32_t>(best_place), view.variants[best_variant].relative_rad, error,
                   error <= same_place_};
}

ViewMatch ByteMatcher::compareWith(const View& view, std::uint32_t id) {
  if (id >= size()) throw std::out_of_range("view: there is none of id " + std::to_string(id));
  setQueries(view);
  std::int32_t product = 0;
  multiply(id, id + 1, 1, &product, 1);
  const double error =
      1.0 - static_cast<double>(static_cast<float>(product) / (query_lengths_[0] * lengths_[id]));
  return {id, view.variants[0].relative_rad, error, error <= same_place_};
}

std::vector<std::int8_t> ByteMatcher::valuesOf(std::uint32_t id) const {
  if (id >= size()) throw std::out_of_range("view: there is none of id " + std::to_string(id));
  std::vector<std::int8_t> values(values_);
  std::transform(vectorAt(id), vectorAt(id) + values_, values.begin(),
                 [](std::uint8_t byte) { return static_cast<std::int8_t>(byte - kBias); });
  return values;
}

View ByteMatcher::learned(std::uint32_t id) const {
  View view;
  view.variants.emplace_back();
  for (const std::int8_t byte : valuesOf(id)) view.variants.front().values.push_back(byte / kLevelsInOne);
  return view;
}

cv::Mat ByteMatcher::picture(std::uint32_t id) const { return painter_(valuesOf(id)); }

cv::Mat ByteMatcher::picture(const View& view) const {
  return painter_(bytesOf(view.variants.at(0).values).values);
}

std::size_t ByteMatcher::memoryBytes() const {
  return segments_.size() * kInSegment * stride_ + lengths_.capacity() * sizeof(float);
}

void ByteMatcher::save(State& state) const {
  std::vector<Row> rows;
  rows.reserve(size());
  for (std::uint32_t id = 0; id < size(); ++id) rows.push_back({valuesOf(id)});
  state.set("templates", rows);
}

void ByteMatcher::load(const State& state) {
  const auto rows = state.get<std::vector<Row>>("templates");
  for (const Row& row : rows) {
    if (row.values.size() == values_) continue;
    throw std::runtime_error("state " + state.path() + "/templates: a template has " +
                             std::to_string(row.values.size()) + " values, not " + std::to_string(values_));
  }
  segments_.clear();
  lengths_.clear();
  for (const Row& row : rows) append(padded(row.values));
}

}  // namespace ratslam
