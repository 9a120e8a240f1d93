/// A template's exact values in few bytes.
///
/// Values are computed from block sums, which are integers. Where the 8-bit value of a block (kept by the
/// SadIndex anyway) says nearly what its sum is, only the rest is stored: log2(full scale of a block / 255)
/// bits or so. With patch normalisation it says nothing, and the sums are stored whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "ratslam/local_view/block_sad/view_template.h"
#include "ratslam/local_view/local_view_params.h"

namespace ratslam {

class PackedTemplate {
 public:
  PackedTemplate(const ViewTemplate& original, const TemplateParams& params);

  /// The values of the original, to the last bit.
  /// @param bytes those values, each quantised, in the same order (row by row).
  std::vector<double> values(const std::vector<std::uint8_t>& bytes, const TemplateParams& params) const;

  std::size_t memoryBytes() const { return sizeof *this + packed_bytes_; }

 private:
  double scale_;
  std::uint64_t full_scale_;
  double sums_per_level_;  // 0 where the 8-bit values do not tell the sums
  std::uint32_t packed_bytes_ = 0;
  std::uint32_t bits_ = 0;  // of each packed number
  std::unique_ptr<std::uint8_t[]> packed_;
};

}  // namespace ratslam
