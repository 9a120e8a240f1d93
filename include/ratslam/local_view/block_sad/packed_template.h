/// Compressed exact values of a template.
///
/// Values are computed from block sums, which are integers. The SadIndex keeps each value in 8 bits, which nearly
/// determine the sum. So only the difference is stored: about log2(full scale of a block / 255) bits. With patch
/// normalisation the 8 bits do not determine the sum, and it is stored whole.
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
  /// Content of a packed template in a State.
  struct Record {
    double scale = 1.0;
    std::uint64_t full_scale = 0;
    double sums_per_level = 0.0;
    std::uint32_t bits = 0;
    std::vector<std::uint8_t> packed;

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("scale", scale);
      fields("full_scale", full_scale);
      fields("sums_per_level", sums_per_level);
      fields("bits", bits);
      fields("packed", packed);
    }
  };

  PackedTemplate(const ViewTemplate& original, const TemplateParams& params);
  /// @param values number of values of the template. @throws std::runtime_error if the record cannot hold them
  PackedTemplate(const Record& record, std::size_t values);

  Record record() const;

  /// The values of the original, to the last bit.
  /// @param bytes those values, each quantised, in the same order (row by row).
  std::vector<double> values(const std::vector<std::uint8_t>& bytes, const TemplateParams& params) const;

  /// The block sums from which those values are computed. Sums above that of value 1 are clamped. So their mean no
  /// longer tells the scale.
  BlockSums blocks(const std::vector<std::uint8_t>& bytes, const TemplateParams& params) const;
  double scale() const { return scale_; }

  std::size_t memoryBytes() const { return sizeof *this + packed_bytes_; }

 private:
  double scale_;
  std::uint64_t full_scale_;
  double sums_per_level_;  // 0 if the 8-bit values do not determine the sums
  std::uint32_t packed_bytes_ = 0;
  std::uint32_t bits_ = 0;  // of each packed number
  std::unique_ptr<std::uint8_t[]> packed_;
};

}  // namespace ratslam
