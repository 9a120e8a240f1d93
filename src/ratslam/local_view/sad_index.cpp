#include "ratslam/local_view/sad_index.h"

#include <algorithm>
#include <cstring>

#include "sad_kernels.h"
#include "sliding_sad.h"

namespace ratslam {
namespace {

constexpr std::size_t kSegmentChunks = 8192;   // 512 KB: a new segment is cheap,
constexpr std::size_t kMaxSegmentGroups = 64;  // also that of a small map, and a search makes few calls

std::size_t asSize(int value) { return static_cast<std::size_t>(value); }

/// Where a group has byte `position` of its first template.
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

/// The masks of the shifts that begin to compare `compared` bytes at `begins`.
ShiftBlock shiftBlock(const std::vector<std::size_t>& begins, std::size_t compared, std::size_t chunks) {
  const auto [first, last] = std::minmax_element(begins.begin(), begins.end());
  ShiftBlock block;
  block.begin = *first / 8;
  block.end = (*last + compared + 7) / 8;
  block.inner_begin = (*last + 7) / 8;
  block.inner_end = (*first + compared) / 8;
  if (block.inner_end <= block.inner_begin) block.inner_begin = block.inner_end = block.end;  // all masked
  block.view.assign(chunks * kBlockShifts, 0);
  block.mask.assign(chunks * kBlockShifts, 0);
  const std::vector<std::uint8_t> set(compared, 255);
  for (std::size_t s = 0; s < kBlockShifts; ++s) spread(set, begins[s], s, block.mask);
  return block;
}

}  // namespace

struct SadIndex::View {
  std::vector<std::vector<std::uint8_t>> compared;  // the view's bytes at each shift
  std::vector<std::size_t> begins;                  // the template's byte which the first of them meets
  SmallestSads smallest_sads = nullptr;             // by columns
  ShiftedViews shifted;
  bool slides = false;  // by rows
  SlidingShape shape;
  std::vector<std::uint32_t> quads;
};

SadIndex::SadIndex(const LocalViewParams& params, int rows, SimdLevel level)
    : rows_(rows),
      columns_(params.view_template.x_size),
      first_column_(params.panoramic ? 0 : params.shift_match),
      step_(params.step_match),
      panoramic_(params.panoramic),
      compared_bytes_(asSize(params.comparedColumns() * rows)),
      view_(std::make_unique<View>()) {
  const std::size_t shifts = asSize(params.shiftCount());
  view_->compared.resize(shifts);
  for (std::size_t i = 0; i < shifts; ++i) {
    view_->begins.push_back(panoramic_ ? 0 : i * asSize(step_ * rows_));
  }
  view_->smallest_sads = smallestSadsFor(level);
  if (level == SimdLevel::kAvx512 && !panoramic_ && step_ == 1 && shifts > kBlockShifts) {
    view_->shape = SlidingShape(asSize(columns_), asSize(rows_), shifts);
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
  const auto count = static_cast<std::uint32_t>(columns_ * rows_);
  for (std::uint32_t i = 0; i < count; ++i) places_.push_back(placeInGroup(i));
  group_chunks_ = (count + 7) / 8;
  view_->shifted.group_chunks = group_chunks_;
  for (std::size_t first = 0; first < view_->begins.size(); first += kBlockShifts) {
    std::vector<std::size_t> begins;
    for (std::size_t s = 0; s < kBlockShifts; ++s) begins.push_back(view_->begins[blockShift(first + s)]);
    view_->shifted.blocks.push_back(shiftBlock(begins, compared_bytes_, group_chunks_));
  }
}

void SadIndex::placeByRows() {
  group_chunks_ = view_->shape.group_chunks;
  view_->quads.resize(view_->shape.rows * view_->shape.quads);
  for (std::size_t x = 0; x < asSize(columns_); ++x) {
    for (std::size_t y = 0; y < asSize(rows_); ++y) {
      places_.push_back(static_cast<std::uint32_t>(view_->shape.chunkOf(x, y) * kChunkBytes + x % 8));
    }
  }
}

/// The last block is filled up with its last shift.
std::size_t SadIndex::blockShift(std::size_t position) const {
  return std::min(position, view_->begins.size() - 1);
}

std::size_t SadIndex::groupCount() const { return (size_ + kGroupLanes - 1) / kGroupLanes; }

std::uint8_t* SadIndex::firstByteOf(std::size_t id) const {
  const std::size_t group = id / kGroupLanes;
  Chunk* segment = segments_[group / segment_groups_].get();
  return segment[group % segment_groups_ * group_chunks_].bytes + id % kGroupLanes * 8;
}

void SadIndex::add(const std::vector<std::uint8_t>& bytes) {
  if (size_ == segments_.size() * segment_groups_ * kGroupLanes) {
    segments_.push_back(std::make_unique<Chunk[]>(segment_groups_ * group_chunks_));
  }
  std::uint8_t* target = firstByteOf(size_);
  for (std::size_t i = 0; i < places_.size(); ++i) target[places_[i]] = bytes[i];
  if (view_->slides) {
    std::uint8_t* excesses = target + view_->shape.excess_chunk * kChunkBytes;
    for (std::size_t shift = 0; shift < view_->begins.size(); ++shift) {
      const std::uint16_t excess = slidingExcess(view_->shape, bytes, shift);
      std::memcpy(excesses + shift / 4 * kChunkBytes + shift % 4 * sizeof excess, &excess, sizeof excess);
    }
  }
  ++size_;
}

std::vector<std::uint8_t> SadIndex::bytes(std::size_t id) const {
  std::vector<std::uint8_t> bytes(places_.size());
  const std::uint8_t* source = firstByteOf(id);
  for (std::size_t i = 0; i < places_.size(); ++i) bytes[i] = source[places_[i]];
  return bytes;
}

void SadIndex::setView(const std::vector<std::uint8_t>& bytes) {
  const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(first_column_) * rows_;
  for (std::size_t i = 0; i < view_->compared.size(); ++i) {
    std::vector<std::uint8_t>& compared = view_->compared[i];
    if (panoramic_) {
      // Column x of the view meets column x + shift of the template.
      const auto split = bytes.end() - static_cast<std::ptrdiff_t>(i * asSize(step_ * rows_));
      compared.assign(split, bytes.end());
      compared.insert(compared.end(), bytes.begin(), split);
    } else {
      compared.assign(first, first + static_cast<std::ptrdiff_t>(compared_bytes_));
    }
  }
  if (view_->slides) {
    auto* words = reinterpret_cast<std::uint8_t*>(view_->quads.data());
    const std::uint8_t* compared = view_->compared[0].data();
    for (std::size_t x = 0; x < view_->shape.compared; ++x) {
      for (std::size_t y = 0; y < asSize(rows_); ++y) words[y * view_->shape.quads * 4 + x] = *compared++;
    }
  }
  for (std::size_t i = 0; i < view_->shifted.blocks.size() * kBlockShifts; ++i) {
    const std::size_t shift = blockShift(i);
    spread(view_->compared[shift], view_->begins[shift], i % kBlockShifts,
           view_->shifted.blocks[i / kBlockShifts].view);
  }
}

void SadIndex::smallestSads(std::size_t first, std::size_t last, std::uint32_t* smallest) const {
  while (first < last) {
    const std::size_t count = std::min(last - first, segment_groups_ - first % segment_groups_);
    const std::uint8_t* groups = firstByteOf(first * kGroupLanes);
    if (view_->slides) {
#if defined(__x86_64__)
      smallestSlidingSads(groups, count, view_->shape, view_->quads, smallest);
#endif
    } else {
      view_->smallest_sads(groups, count, view_->shifted, smallest);
    }
    smallest += count * kGroupLanes;
    first += count;
  }
}

std::uint32_t SadIndex::sad(const std::vector<std::uint8_t>& template_bytes, int shift_number) const {
  const std::uint8_t* view = view_->compared[asSize(shift_number)].data();
  const std::uint8_t* learned = template_bytes.data() + view_->begins[asSize(shift_number)];
  std::uint32_t sum = 0;
  for (std::size_t b = 0; b < compared_bytes_; ++b) {
    const int difference = static_cast<int>(view[b]) - static_cast<int>(learned[b]);
    sum += static_cast<std::uint32_t>(difference < 0 ? -difference : difference);
  }
  return sum;
}

std::size_t SadIndex::memoryBytes() const {
  return segments_.size() * segment_groups_ * group_chunks_ * sizeof(Chunk);
}

}  // namespace ratslam
