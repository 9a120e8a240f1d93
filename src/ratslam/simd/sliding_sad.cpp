#include <limits>

#include "levels.h"

namespace ratslam {
namespace {

constexpr std::size_t kSlides = 3;       // groups of 4 shifts that share what is loaded of a template
constexpr std::size_t kUsualQuads = 13;  // of 60 columns at shifts of up to 5 to either side
constexpr std::size_t kUsualFetchedChunks = 8;
constexpr std::size_t kMaxQuads = 64;  // 4 differences of bytes each, so that their sum stays below 2^16

}  // namespace

SlidingShape::SlidingShape(std::size_t columns, std::size_t rows_, std::size_t shifts)
    : rows(rows_),
      shift_count(shifts),
      compared(columns + 1 - shifts),
      quads((compared + 3) / 4),
      row_quads((columns + 3) / 4) {
  const std::size_t slides = (shift_count + 4 * kSlides - 1) / (4 * kSlides) * kSlides;
  const std::size_t last_read = (rows - 1) * row_quads + quads + slides - 1;  // quad
  excess_chunk = last_read / 2 + 1;
  group_chunks = excess_chunk + slides;
  fetched_chunks = (group_chunks + rows - 1) / rows;
}

bool SlidingShape::isSupported() const {
  return quads <= kMaxQuads && rows * 3 * 255 <= std::numeric_limits<std::uint16_t>::max();
}

std::uint16_t slidingExcess(const SlidingShape& shape, const std::vector<std::uint8_t>& bytes,
                            std::size_t shift) {
  const std::size_t columns = bytes.size() / shape.rows;
  const std::size_t row_bytes = shape.row_quads * 4;
  std::uint32_t sum = 0;
  for (std::size_t y = 0; y < shape.rows; ++y) {
    for (std::size_t x = shift + shape.compared; x < shift + shape.quads * 4; ++x) {
      const std::size_t row = y + x / row_bytes;
      const std::size_t column = x % row_bytes;
      if (row < shape.rows && column < columns) sum += bytes[column * shape.rows + row];
    }
  }
  return static_cast<std::uint16_t>(sum);
}

#if defined(__x86_64__)

#define RATSLAM_AVX512 __attribute__((target("avx512f,avx512bw")))

namespace {

/// 16-bit sums of 4 shifts in each of 8 templates, and what they were before they could overflow.
struct SlideSums {
  __m512i words;
  __m512i even;  // of shifts 0 and 2, 32 bits each
  __m512i odd;   // of shifts 1 and 3
};

RATSLAM_AVX512 inline void widen(SlideSums& sums) {
  sums.even = _mm512_add_epi32(sums.even, _mm512_and_si512(sums.words, _mm512_set1_epi32(0xffff)));
  sums.odd = _mm512_add_epi32(sums.odd, _mm512_maskz_srli_epi32(0xffff, sums.words, 16));
  sums.words = _mm512_setzero_si512();
}

/// From the halves of 8 bytes that two neighbouring chunks have of each template, the 8 bytes between them,
/// halves swapped: dbsad swaps them back on its way.
RATSLAM_AVX512 inline __m512i joined(__m512i chunk, __m512i next) {
  constexpr __mmask16 kSecondHalves = 0xaaaa;
  return _mm512_mask_blend_epi32(kSecondHalves, next, chunk);
}

/// The sums never saturate, but unlike a plain addition this one leaves the execution unit of dbsad alone.
template <bool kJoined>
RATSLAM_AVX512 inline void addQuad(SlideSums& sums, const std::uint32_t& quad, __m512i learned) {
  constexpr int kHalves = kJoined ? 0xb1 : 0xe4;
  const __m512i view = _mm512_set1_epi32(static_cast<int>(quad));
  sums.words = _mm512_adds_epu16(sums.words, _mm512_dbsad_epu8(view, learned, kHalves));
}

/// Fetches chunks of a later group; addresses that hold nothing do no harm.
inline void prefetch(const std::uint8_t* chunks, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) _mm_prefetch(chunks + i * 64, _MM_HINT_T0);
}

/// The smaller of `least` and the sums of the shifts first, first + 1, ... first + 3, where they exist.
RATSLAM_AVX512 inline __m512i leastOf(__m512i least, const SlideSums& sums, const std::uint8_t* excess,
                                      std::size_t first, std::size_t count) {
  const __m512i words = _mm512_load_si512(excess);
  const __m512i even = _mm512_sub_epi32(sums.even, _mm512_and_si512(words, _mm512_set1_epi32(0xffff)));
  const __m512i odd = _mm512_sub_epi32(sums.odd, _mm512_maskz_srli_epi32(0xffff, words, 16));
  const auto beyond = [&](std::size_t shift) { return first + shift < count ? 0LL : 0xffffffffLL; };
  const __m512i no_even = _mm512_set1_epi64(beyond(2) << 32 | beyond(0));
  const __m512i no_odd = _mm512_set1_epi64(beyond(3) << 32 | beyond(1));
  least = _mm512_maskz_min_epu32(0xffff, least, _mm512_or_si512(even, no_even));
  return _mm512_maskz_min_epu32(0xffff, least, _mm512_or_si512(odd, no_odd));
}

/// Adds one quad of a row of the view, which meets those number q, q + 1 and q + 2 of a row of the templates.
template <bool kFirstJoined>
RATSLAM_AVX512 inline void addQuads(SlideSums (&sums)[kSlides], const std::uint32_t& quad, __m512i first,
                                    __m512i second, __m512i third) {
  addQuad<kFirstJoined>(sums[0], quad, first);
  addQuad<!kFirstJoined>(sums[1], quad, second);
  addQuad<kFirstJoined>(sums[2], quad, third);
}

RATSLAM_AVX512 inline __m512i chunkAt(const std::uint8_t* group, std::size_t chunk) {
  return _mm512_load_si512(group + chunk * 64);
}
RATSLAM_AVX512 inline __m512i between(const std::uint8_t* group, std::size_t chunk) {
  return joined(chunkAt(group, chunk), chunkAt(group, chunk + 1));
}

/// Adds the quads [0, quads) of a row of the view, which meet those from `start`, start + 1 and start + 2 on
/// of the templates. Even quads are chunks, odd ones lie between two: two a turn, so that the execution unit
/// of dbsad has nothing to wait for. Their number is a constant where `kQuads` is not 0, which lets the
/// compiler unroll.
template <bool kOddStart, std::size_t kQuads>
RATSLAM_AVX512 inline void addRow(const std::uint8_t* group, const std::uint32_t* view, std::size_t any_quads,
                                  std::size_t start, SlideSums (&sums)[kSlides]) {
  const std::size_t quads = kQuads > 0 ? kQuads : any_quads;
  std::size_t c = start / 2;
  __m512i first = kOddStart ? between(group, c) : chunkAt(group, c);
  __m512i second = kOddStart ? chunkAt(group, c + 1) : between(group, c);
  if (kOddStart) ++c;
  std::size_t q = 0;
  for (; q + 1 < quads; q += 2, ++c) {
    const __m512i third = kOddStart ? between(group, c) : chunkAt(group, c + 1);
    const __m512i fourth = kOddStart ? chunkAt(group, c + 1) : between(group, c + 1);
    addQuads<kOddStart>(sums, view[q], first, second, third);
    addQuads<!kOddStart>(sums, view[q + 1], second, third, fourth);
    first = third;
    second = fourth;
  }
  if (q == quads) return;
  addQuads<kOddStart>(sums, view[q], first, second, kOddStart ? between(group, c) : chunkAt(group, c + 1));
}

/// Sizes that are constants where they are not 0.
template <std::size_t kQuads, std::size_t kFetchedChunks>
RATSLAM_AVX512 void smallestSads(const std::uint8_t* groups, std::size_t group_count,
                                 const SlidingShape shape, const std::uint32_t* view,
                                 std::uint32_t* smallest) {
  const std::size_t quads = kQuads > 0 ? kQuads : shape.quads;
  const std::size_t rows_held = kMaxQuads / quads;  // by 16-bit sums
  const std::size_t fetched_chunks = kFetchedChunks > 0 ? kFetchedChunks : shape.fetched_chunks;
  const std::size_t group_bytes = shape.group_chunks * 64;
  for (std::size_t group = 0; group < group_count; ++group) {
    const std::uint8_t* bytes = groups + group * group_bytes;
    __m512i least = _mm512_set1_epi32(-1);
    for (std::size_t slide = 0; slide * 4 < shape.shift_count; slide += kSlides) {
      const __m512i zero = _mm512_setzero_si512();
      SlideSums sums[kSlides] = {{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}};
      const std::uint8_t* later = bytes + 2 * group_bytes;
      const std::uint32_t* view_row = view;
      std::size_t start = slide;
      for (std::size_t begin = 0; begin < shape.rows; begin += rows_held) {
        const std::size_t end = std::min(begin + rows_held, shape.rows);
        for (std::size_t y = begin; y < end; ++y, start += shape.row_quads, view_row += quads) {
          // A bit of the group after the next with every row: all at once would stall.
          prefetch(later, fetched_chunks);
          later += fetched_chunks * 64;
          if (start % 2 == 0) {
            addRow<false, kQuads>(bytes, view_row, quads, start, sums);
          } else {
            addRow<true, kQuads>(bytes, view_row, quads, start, sums);
          }
        }
        for (SlideSums& sum : sums) widen(sum);
      }
      for (std::size_t i = 0; i < kSlides; ++i) {
        const std::uint8_t* excess = bytes + (shape.excess_chunk + slide + i) * 64;
        least = leastOf(least, sums[i], excess, 4 * (slide + i), shape.shift_count);
      }
    }
    least = _mm512_maskz_min_epu32(0xffff, least, _mm512_maskz_srli_epi64(0xff, least, 32));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(smallest + group * 8),
                        _mm512_maskz_cvtepi64_epi32(0xff, least));
  }
}

}  // namespace

void slidingSadsAvx512(const std::uint8_t* groups, std::size_t group_count, const SlidingShape& shape,
                       const std::vector<std::uint32_t>& view, std::uint32_t* smallest) {
  if (shape.quads == kUsualQuads && shape.fetched_chunks == kUsualFetchedChunks) {
    smallestSads<kUsualQuads, kUsualFetchedChunks>(groups, group_count, shape, view.data(), smallest);
  } else {
    smallestSads<0, 0>(groups, group_count, shape, view.data(), smallest);
  }
}

#undef RATSLAM_AVX512

#endif

}  // namespace ratslam
