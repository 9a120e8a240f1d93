/// Templates as 8-bit values, laid out for fast sums of absolute differences (SAD) with a view at many
/// shifts.
///
/// Templates are kept in groups of 8, their bytes interleaved (sad_kernels.h), and groups in segments that
/// never move: adding costs O(1). The bytes of a group go column by column, so that the columns which one
/// shift compares are one run of bytes; or row by row where a faster kernel wants that (sliding_sad.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "ratslam/common/simd_level.h"
#include "ratslam/local_view/local_view_params.h"

namespace ratslam {

class SadIndex {
 public:
  /// @param rows values in each of the template's columns.
  SadIndex(const LocalViewParams& params, int rows, SimdLevel level);
  ~SadIndex();
  SadIndex(SadIndex&&) noexcept;
  SadIndex& operator=(SadIndex&&) noexcept;

  /// @param bytes columns x rows values, column by column, here and below.
  void add(const std::vector<std::uint8_t>& bytes);

  /// Template `id`, as it was added.
  std::vector<std::uint8_t> bytes(std::size_t id) const;

  std::size_t groupCount() const;

  /// Number of values compared at each shift: no SAD exceeds 255 times it.
  std::size_t comparedBytes() const { return compared_bytes_; }

  /// Lays a view out for the searches that follow.
  void setView(const std::vector<std::uint8_t>& bytes);

  /// For each template of the groups [first, last), its smallest SAD over all shifts. The last group may be
  /// partly empty: what it gives for templates that are not there means nothing.
  /// @param smallest 8 values a group.
  void smallestSads(std::size_t first, std::size_t last, std::uint32_t* smallest) const;

  /// SAD of the view and one template at one shift. @param template_bytes what bytes(id) gives.
  std::uint32_t sad(const std::vector<std::uint8_t>& template_bytes, int shift_number) const;

  std::size_t memoryBytes() const;

 private:
  struct alignas(64) Chunk {
    std::uint8_t bytes[64];
  };
  struct View;

  void placeByColumns();
  void placeByRows();
  std::size_t blockShift(std::size_t position) const;
  std::uint8_t* firstByteOf(std::size_t id) const;

  int rows_;
  int columns_;
  int first_column_;  // of the view that is compared
  int step_;
  bool panoramic_;
  std::size_t compared_bytes_;
  std::size_t group_chunks_ = 0;
  std::size_t segment_groups_ = 1;
  std::vector<std::uint32_t> places_;  // of each byte of the first template in a group
  std::size_t size_ = 0;
  std::vector<std::unique_ptr<Chunk[]>> segments_;
  std::unique_ptr<View> view_;
};

}  // namespace ratslam
