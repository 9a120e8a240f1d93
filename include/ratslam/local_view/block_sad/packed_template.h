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
  /// All there is to know, as a State keeps it.
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
  /// @param values how many the template has. @throws std::runtime_error where the record cannot hold them
  PackedTemplate(const Record& record, std::size_t values);

  Record record() const;

  /// The values of the original, to the last bit.
  /// @param bytes those values, each quantised, in the same order (row by row).
  std::vector<double> values(const std::vector<std::uint8_t>& bytes, const TemplateParams& params) const;

  /// The block sums that those values are computed from; above what makes a value of 1 they are cut.
  BlockSums blocks(const std::vector<std::uint8_t>& bytes, const TemplateParams& params) const;

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
