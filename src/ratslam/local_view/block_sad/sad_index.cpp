#include "ratslam/local_view/block_sad/sad_index.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "ratslam/local_view/block_sad/view_template.h"
#include "ratslam/simd/sad_kernels.h"
#include "ratslam/simd/sliding_sad.h"

namespace ratslam {
namespace {

constexpr std::size_t kSegmentChunks = 8192;   // 512 KB: a new segment is cheap, and a search makes few calls
constexpr std::size_t kMaxSegmentGroups = 64;  // keeps the segments of small templates small

/// Position in a group of byte `position` of its first template.
std::uint32_t placeInGroup(std::uint32_t position) {
  return position / 8 * static_cast<std::uint32_t>(kChunkBytes) + position % 8;
}

/// Writes `bytes` at byte `begin` of shift number `shift` of a block.
void spread(const std::vector<std::uint8_t>& bytes, std::size_t begin, std::size_t shift,
            std::vector<std::uint64_t>& words) {
  auto* target = reinterpret_cast<std::uint8_t*>(words.data());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const std::size_t position = begin + i;
    target[(position / 8 * kBlockShifts + shift) * 8 + position % 8] = bytes[i];
  }
}

/// The masks of the shifts that compare these runs of `bytes` bytes.
ShiftBlock shiftBlock(const std::vector<BlockRun>& runs, std::size_t bytes, std::size_t chunks) {
  ShiftBlock block;
  std::size_t last_begin = 0;
  std::size_t first_begin = chunks * 8;
  std::size_t first_end = chunks * 8;
  std::size_t last_end = 0;
  block.view.assign(chunks * kBlockShifts, 0);
  block.mask.assign(chunks * kBlockShifts, 0);
  for (std::size_t s = 0; s < kBlockShifts; ++s) {
    const BlockRun& run = runs[s];
    first_begin = std::min(first_begin, run.begin);
    last_begin = std::max(last_begin, run.begin);
    first_end = std::min(first_end, run.begin + run.count);
    last_end = std::max(last_end, run.begin + run.count);
    spread(std::vector<std::uint8_t>(run.count, 255), run.begin, s, block.mask);
  }
  block.begin = first_begin / 8;
  block.end = (last_end + 7) / 8;
  block.inner_begin = (last_begin + 7) / 8;
  block.inner_end =
      first_end == bytes ? chunks : first_end / 8;  // the bytes after the end are 0 on both sides
  if (block.inner_end <= block.inner_begin) block.inner_begin = block.inner_end = block.end;  // all masked
  return block;
}

}  // namespace

struct SadIndex::View {
  const std::vector<std::uint8_t>& at(std::size_t shift) const {
    return compared[std::min(shift, compared.size() - 1)];
  }

  std::vector<std::vector<std::uint8_t>>
      compared;                          // blocks of the view at each shift, or once for all shifts
  SmallestSads smallest_sads = nullptr;  // by columns
  ShiftedViews shifted;
  SlidingSads sliding_sads = nullptr;  // by rows; null if this level has none
  bool slides = false;
  SlidingShape shape;
  std::vector<std::uint32_t> quads;
};

SadIndex::SadIndex(BlockGrid grid, SimdLevel level)
    : grid_(std::move(grid)), view_(std::make_unique<View>()) {
  const std::size_t shifts = grid_.runs().size();
  view_->smallest_sads = smallestSadsFor(level);
  view_->sliding_sads = slidingSadsFor(level);
  if (view_->sliding_sads != nullptr && grid_.slidesByValues() && shifts > kBlockShifts) {
    view_->shape = SlidingShape(grid_.columns(), grid_.rows(), shifts);
    view_->slides = view_->shape.isSupported();
  }
  if (view_->slides) {
    placeByRows();
  } else {
    placeByColumns();
  }
  segment_groups_ =
      std::clamp<std::size_t>(kSegmentChunks / std::max<std::size_t>(group_chunks_, 1), 1, kMaxSegmentGroups);
}

SadIndex::~SadIndex() = default;
SadIndex::SadIndex(SadIndex&&) noexcept = default;
SadIndex& SadIndex::operator=(SadIndex&&) noexcept = default;

void SadIndex::placeByColumns() {
  const auto count = static_cast<std::uint32_t>(grid_.columns() * grid_.rows());
  for (std::uint32_t i = 0; i < count; ++i) places_.push_back(placeInGroup(i));
  group_chunks_ = (count + 7) / 8;
  view_->shifted.group_chunks = group_chunks_;
  view_->shifted.most_compared = grid_.mostCompared();
  for (std::size_t first = 0; first < grid_.runs().size(); first += kBlockShifts) {
    std::vector<BlockRun> runs;
    for (std::size_t s = 0; s < kBlockShifts; ++s) runs.push_back(grid_.runs()[blockShift(first + s)]);
    view_->shifted.blocks.push_back(shiftBlock(runs, count, group_chunks_));
  }
}

void SadIndex::placeByRows() {
  group_chunks_ = view_->shape.group_chunks;
  view_->quads.resize(view_->shape.rows * view_->shape.quads);
  for (std::size_t x = 0; x < grid_.columns(); ++x) {
    for (std::size_t y = 0; y < grid_.rows(); ++y) {
      places_.push_back(static_cast<std::uint32_t>(view_->shape.placeOf(x, y)));
    }
  }
}

/// Shift at a position of the blocks of shifts. The last block is filled with repetitions of the last shift.
std::size_t SadIndex::blockShift(std::size_t position) const {
  return std::min(position, grid_.runs().size() - 1);
}

std::size_t SadIndex::groupCount() const { return (size_ + kGroupLanes - 1) / kGroupLanes; }

std::uint8_t* SadIndex::firstByteOf(std::size_t id) const {
  const std::size_t group = id / kGroupLanes;
  Chunk* segment = segments_[group / segment_groups_].get();
  return segment[group % segment_groups_ * group_chunks_].bytes + id % kGroupLanes * 8;
}

void SadIndex::add(const std::vector<double>& values) {
  const std::vector<std::uint8_t> bytes = grid_.ofTemplate(values);
  if (size_ == segments_.size() * segment_groups_ * kGroupLanes) {
    segments_.push_back(std::make_unique<Chunk[]>(segment_groups_ * group_chunks_));
  }
  std::uint8_t* target = firstByteOf(size_);
  for (std::size_t i = 0; i < places_.size(); ++i) target[places_[i]] = bytes[i];
  if (view_->slides) {
    std::uint8_t* excesses = target + view_->shape.excess_chunk * kChunkBytes;
    for (std::size_t shift = 0; shift < grid_.runs().size(); ++shift) {
      const std::uint16_t excess = slidingExcess(view_->shape, bytes, shift);
      std::memcpy(excesses + shift / 4 * kChunkBytes + shift % 4 * sizeof excess, &excess, sizeof excess);
    }
  }
  ++size_;
}

std::vector<std::uint8_t> SadIndex::bytes(std::size_t id) const {
  const std::size_t count = places_.size();
  const std::size_t rows = grid_.rows();
  const std::uint32_t* places = places_.data();
  const std::uint8_t* source = firstByteOf(id);
  std::vector<std::uint8_t> bytes(count);
  auto next = bytes.begin();
  for (std::size_t y = 0; y < rows; ++y) {
    for (std::size_t i = y; i < count; i += rows) *next++ = source[places[i]];
  }
  return bytes;
}

void SadIndex::setView(const std::vector<double>& values) {
  if (view_->slides) {
    auto* row = reinterpret_cast<std::uint8_t*>(view_->quads.data());
    const double* compared = values.data() + grid_.firstComparedColumn();
    for (std::size_t y = 0; y < grid_.rows(); ++y) {
      std::transform(compared, compared + view_->shape.compared, row,
                     [](double value) { return quantised(value); });
      row += view_->shape.quads * 4;
      compared += grid_.columns();
    }
    return;
  }
  grid_.ofView(values, view_->compared);
  for (std::size_t i = 0; i < view_->shifted.blocks.size() * kBlockShifts; ++i) {
    const std::size_t shift = blockShift(i);
    spread(view_->at(shift), grid_.runs()[shift].begin, i % kBlockShifts,
           view_->shifted.blocks[i / kBlockShifts].view);
  }
}

void SadIndex::smallestSads(std::size_t first, std::size_t last, std::uint32_t* smallest) const {
  while (first < last) {
    const std::size_t count = std::min(last - first, segment_groups_ - first % segment_groups_);
    const std::uint8_t* groups = firstByteOf(first * kGroupLanes);
    if (view_->slides) {
      view_->sliding_sads(groups, count, view_->shape, view_->quads, smallest);
    } else {
      view_->smallest_sads(groups, count, view_->shifted, smallest);
    }
    smallest += count * kGroupLanes;
    first += count;
  }
}

std::size_t SadIndex::memoryBytes() const {
  return segments_.size() * segment_groups_ * group_chunks_ * sizeof(Chunk);
}

}  // namespace ratslam
