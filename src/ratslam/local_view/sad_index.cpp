#include "ratslam/local_view/sad_index.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "sad_kernels.h"

namespace ratslam {
namespace {

constexpr std::size_t kSegmentGroups = 32;  // a new segment is cheap, and a search makes few calls

std::size_t asSize(int value) { return static_cast<std::size_t>(value); }

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
  SmallestSads smallest_sads = nullptr;
  ShiftedViews shifted;
  std::vector<std::vector<std::uint8_t>> compared;  // the view's bytes at each shift
  std::vector<std::size_t> begins;                  // the template's byte which the first of them meets
};

SadIndex::SadIndex(const LocalViewParams& params, int rows, SimdLevel level)
    : rows_(rows),
      columns_(params.view_template.x_size),
      first_column_(params.panoramic ? 0 : params.shift_match),
      step_(params.step_match),
      panoramic_(params.panoramic),
      compared_bytes_(asSize(params.comparedColumns() * rows)),
      template_bytes_(asSize(columns_ * rows)),
      group_chunks_((template_bytes_ + 7) / 8),
      view_(std::make_unique<View>()) {
  view_->smallest_sads = smallestSadsFor(level);
  view_->shifted.group_chunks = group_chunks_;
  const std::size_t shifts = asSize(params.shiftCount());
  view_->compared.resize(shifts);
  for (std::size_t i = 0; i < shifts; ++i)
    view_->begins.push_back(panoramic_ ? 0 : i * asSize(step_ * rows_));
  for (std::size_t first = 0; first < shifts; first += kBlockShifts) {
    std::vector<std::size_t> begins;
    for (std::size_t s = 0; s < kBlockShifts; ++s) begins.push_back(view_->begins[blockShift(first + s)]);
    view_->shifted.blocks.push_back(shiftBlock(begins, compared_bytes_, group_chunks_));
  }
}

SadIndex::~SadIndex() = default;
SadIndex::SadIndex(SadIndex&&) noexcept = default;
SadIndex& SadIndex::operator=(SadIndex&&) noexcept = default;

std::size_t SadIndex::groupCount() const { return (size_ + kGroupLanes - 1) / kGroupLanes; }

std::uint8_t* SadIndex::chunkOf(std::size_t id, std::size_t chunk) const {
  const std::size_t group = id / kGroupLanes;
  Chunk* segment = segments_[group / kSegmentGroups].get();
  return segment[group % kSegmentGroups * group_chunks_ + chunk].bytes + id % kGroupLanes * 8;
}

void SadIndex::add(const std::vector<std::uint8_t>& bytes) {
  if (size_ == segments_.size() * kSegmentGroups * kGroupLanes) {
    segments_.push_back(std::make_unique<Chunk[]>(kSegmentGroups * group_chunks_));
  }
  for (std::size_t begin = 0; begin < template_bytes_; begin += 8) {
    std::memcpy(chunkOf(size_, begin / 8), bytes.data() + begin,
                std::min<std::size_t>(8, template_bytes_ - begin));
  }
  ++size_;
}

std::vector<std::uint8_t> SadIndex::bytes(std::size_t id) const {
  std::vector<std::uint8_t> bytes(template_bytes_);
  for (std::size_t begin = 0; begin < template_bytes_; begin += 8) {
    std::memcpy(bytes.data() + begin, chunkOf(id, begin / 8),
                std::min<std::size_t>(8, template_bytes_ - begin));
  }
  return bytes;
}

/// The last block is filled up with its last shift.
std::size_t SadIndex::blockShift(std::size_t position) const {
  return std::min(position, view_->compared.size() - 1);
}

void SadIndex::setView(const std::vector<std::uint8_t>& bytes) {
  const auto first = bytes.begin() + first_column_ * rows_;
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
  for (std::size_t i = 0; i < view_->shifted.blocks.size() * kBlockShifts; ++i) {
    const std::size_t shift = blockShift(i);
    spread(view_->compared[shift], view_->begins[shift], i % kBlockShifts,
           view_->shifted.blocks[i / kBlockShifts].view);
  }
}

void SadIndex::smallestSads(std::size_t first, std::size_t last, std::uint32_t* smallest) const {
  while (first < last) {
    const std::size_t count = std::min(last - first, kSegmentGroups - first % kSegmentGroups);
    view_->smallest_sads(chunkOf(first * kGroupLanes, 0), count, view_->shifted, smallest);
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
  return segments_.size() * kSegmentGroups * group_chunks_ * sizeof(Chunk);
}

}  // namespace ratslam
