#include "ratslam/local_view/block_sad/packed_template.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

namespace ratslam {
namespace {

constexpr std::size_t kReadBytes = 8;    // a number is read as part of a whole 64-bit word
constexpr std::uint32_t kMostBits = 57;  // bits of such a word after up to 7 bits of the number before

std::uint32_t bitsOf(std::uint64_t largest) {
  std::uint32_t bits = 0;
  for (; largest > 0; largest >>= 1U) ++bits;
  return bits;
}

/// The smallest sum whose value rounds to a given byte.
std::uint64_t smallestSum(std::uint8_t byte, double sums_per_level) {
  // The first whole number from half a level below the byte on, minus the possible rounding of the value and of this
  // product. It truncates, because std::ceil costs a call on older processors.
  const double sum = (byte - 0.5) * sums_per_level * (1.0 - 1e-12) + (1.0 - 1e-9);
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::max(sum, 0.0)));
}

}  // namespace

PackedTemplate::PackedTemplate(const ViewTemplate& original, const TemplateParams& params)
    : scale_(original.scale), full_scale_(original.blocks.full_scale) {
  const double white = static_cast<double>(full_scale_) / scale_;  // the sum from which a value is 1
  sums_per_level_ = params.patch_radius > 0 ? 0.0 : white / 255.0;
  // A sum beyond white gives 1 like white itself; the margin of 1 covers the rounding of `white`.
  const auto saturated = static_cast<std::uint64_t>(std::ceil(white)) + 1;

  std::vector<std::uint64_t> rests;
  rests.reserve(original.values.size());
  for (std::size_t i = 0; i < original.values.size(); ++i) {
    const std::uint64_t sum = std::min(original.blocks.sums[i], saturated);
    rests.push_back(sum - smallestSum(quantised(original.values[i]), sums_per_level_));
  }
  bits_ = bitsOf(*std::max_element(rests.begin(), rests.end()));
  packed_bytes_ = static_cast<std::uint32_t>(rests.size() * bits_ / 8 + kReadBytes);
  packed_ = std::make_unique<std::uint8_t[]>(packed_bytes_);
  std::size_t position = 0;  // the bits are in little-endian order
  for (const std::uint64_t rest : rests) {
    std::uint64_t word = 0;
    std::memcpy(&word, packed_.get() + position / 8, kReadBytes);
    word |= rest << (position % 8);
    std::memcpy(packed_.get() + position / 8, &word, kReadBytes);
    position += bits_;
  }
}

PackedTemplate::PackedTemplate(const Record& record, std::size_t values)
    : scale_(record.scale),
      full_scale_(record.full_scale),
      sums_per_level_(record.sums_per_level),
      packed_bytes_(static_cast<std::uint32_t>(record.packed.size())),
      bits_(record.bits) {
  const bool fits = bits_ <= kMostBits && record.packed.size() == values * bits_ / 8 + kReadBytes;
  if (!fits || !(scale_ > 0.0) || full_scale_ == 0) {
    throw std::runtime_error("view template: its record does not hold " + std::to_string(values) + " values");
  }
  packed_ = std::make_unique<std::uint8_t[]>(packed_bytes_);
  std::copy(record.packed.begin(), record.packed.end(), packed_.get());
}

PackedTemplate::Record PackedTemplate::record() const {
  return {scale_, full_scale_, sums_per_level_, bits_, {packed_.get(), packed_.get() + packed_bytes_}};
}

std::vector<double> PackedTemplate::values(const std::vector<std::uint8_t>& bytes,
                                           const TemplateParams& params) const {
  return templateValues(blocks(bytes, params), scale_, params);
}

BlockSums PackedTemplate::blocks(const std::vector<std::uint8_t>& bytes, const TemplateParams& params) const {
  BlockSums blocks;
  blocks.columns = params.x_size;
  blocks.rows = params.y_size;
  blocks.full_scale = full_scale_;
  blocks.sums.resize(bytes.size());
  std::array<std::uint64_t, 256> smallest_sums;
  for (std::size_t byte = 0; byte < smallest_sums.size(); ++byte) {
    smallest_sums[byte] = smallestSum(static_cast<std::uint8_t>(byte), sums_per_level_);
  }
  const std::uint64_t mask = (std::uint64_t{1} << bits_) - 1;
  std::size_t position = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i, position += bits_) {
    std::uint64_t word = 0;
    std::memcpy(&word, packed_.get() + position / 8, kReadBytes);
    blocks.sums[i] = smallest_sums[bytes[i]] + ((word >> (position % 8)) & mask);
  }
  return blocks;
}

}  // namespace ratslam
