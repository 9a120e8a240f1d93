#include "ratslam/local_view/sad_index.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "sad_kernels.h"

namespace ratslam {
namespace {

constexpr std::size_t kSegmentGroups = 32;  // a new segment is cheap, and a search makes few calls

std::size_t asSize(int value) { return static_cast<std::size_t>(value); }

/// Chunk number `chunk` of a view laid out at one shift, compared at the bytes [begin, end) of a template.
MaskedChunk maskedChunk(const std::uint64_t* view, std::size_t chunk, std::size_t begin, std::size_t end) {
  std::uint8_t mask[8];
  for (std::size_t i = 0; i < 8; ++i) {
    const std::size_t position = chunk * 8 + i;
    mask[i] = position >= begin && position < end ? 255 : 0;
  }
  MaskedChunk masked{chunk, view[chunk], 0};
  std::memcpy(&masked.mask, mask, sizeof mask);
  return masked;
}

}  // namespace

struct SadIndex::View {
  SmallestSads smallest_sads = nullptr;
  std::vector<std::uint64_t> laid_out;  // shifts x group_chunks, 0 where nothing is compared
  std::vector<ShiftedView> shifts;
  std::vector<std::size_t> begins;  // byte of a template at which the compared ones begin, for each shift
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
  view_->shifts.resize(asSize(params.shiftCount()));
  view_->laid_out.assign(view_->shifts.size() * group_chunks_, 0);
  for (std::size_t i = 0; i < view_->shifts.size(); ++i) {
    view_->begins.push_back(panoramic_ ? 0 : i * asSize(step_ * rows_));
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

void SadIndex::setView(const std::vector<std::uint8_t>& bytes) {
  for (std::size_t i = 0; i < view_->shifts.size(); ++i) {
    std::uint64_t* laid_out = view_->laid_out.data() + i * group_chunks_;
    const std::size_t begin = view_->begins[i];
    const std::size_t end = begin + compared_bytes_;
    if (panoramic_) {
      // Column x of the view meets column x + shift of the template.
      const auto split = bytes.end() - static_cast<std::ptrdiff_t>(i * asSize(step_ * rows_));
      std::vector<std::uint8_t> turned(split, bytes.end());
      turned.insert(turned.end(), bytes.begin(), split);
      std::memcpy(laid_out, turned.data(), turned.size());
    } else {
      std::memcpy(reinterpret_cast<std::uint8_t*>(laid_out) + begin,
                  bytes.data() + asSize(first_column_ * rows_), compared_bytes_);
    }
    ShiftedView& shift = view_->shifts[i];
    const std::size_t head = begin / 8;
    const std::size_t tail = (end - 1) / 8;
    shift.head = maskedChunk(laid_out, head, begin, end);
    shift.tail = tail > head ? maskedChunk(laid_out, tail, begin, end) : MaskedChunk{head, 0, 0};
    shift.middle_chunk = head + 1;
    shift.middle_count = tail > head ? tail - head - 1 : 0;
    shift.middle_view = laid_out + shift.middle_chunk;
  }
}

void SadIndex::smallestSads(std::size_t first, std::size_t last, std::uint32_t* smallest) const {
  const ShiftedViews views{view_->shifts.data(), view_->shifts.size(), group_chunks_};
  while (first < last) {
    const std::size_t count = std::min(last - first, kSegmentGroups - first % kSegmentGroups);
    view_->smallest_sads(chunkOf(first * kGroupLanes, 0), count, views, smallest);
    smallest += count * kGroupLanes;
    first += count;
  }
}

std::uint32_t SadIndex::sad(const std::vector<std::uint8_t>& template_bytes, int shift_number) const {
  const std::size_t i = asSize(shift_number);
  const std::size_t begin = view_->begins[i];
  const auto* view =
      reinterpret_cast<const std::uint8_t*>(view_->laid_out.data() + i * group_chunks_) + begin;
  const std::uint8_t* learned = template_bytes.data() + begin;
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
