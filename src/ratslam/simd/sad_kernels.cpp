#include <limits>

#include "levels.h"

#if defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace ratslam {

namespace {

std::uint32_t chunkSad(const std::uint8_t* bytes, std::uint64_t view, std::uint64_t mask) {
  std::uint64_t learned = 0;
  std::memcpy(&learned, bytes, sizeof learned);
  learned &= mask;
  std::uint32_t sum = 0;
  for (int bit = 0; bit < 64; bit += 8) {
    const int difference = static_cast<int>((learned >> bit) & 255U) - static_cast<int>((view >> bit) & 255U);
    sum += static_cast<std::uint32_t>(difference < 0 ? -difference : difference);
  }
  return sum;
}

}  // namespace

void smallestSadsScalar(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                        std::uint32_t* smallest) {
  for (std::size_t lane = 0; lane < group_count * kGroupLanes; ++lane) {
    const std::uint8_t* bytes =
        groups + lane / kGroupLanes * views.group_chunks * kChunkBytes + lane % kGroupLanes * 8;
    std::uint32_t least = std::numeric_limits<std::uint32_t>::max();
    for (const ShiftBlock& block : views.blocks) {
      std::uint32_t sums[kBlockShifts] = {};
      for (std::size_t c = block.begin; c < block.end; ++c) {
        for (std::size_t s = 0; s < kBlockShifts; ++s) {
          const std::size_t i = c * kBlockShifts + s;
          sums[s] += chunkSad(bytes + c * kChunkBytes, block.view[i], block.mask[i]);
        }
      }
      least = std::min(least, *std::min_element(sums, sums + kBlockShifts));
    }
    smallest[lane] = least;
  }
}

#if defined(__x86_64__)

namespace {

inline __m128i broadcast128(const std::uint64_t& word) {
  return _mm_set1_epi64x(static_cast<long long>(word));
}

inline void addMasked128(const std::uint8_t* bytes, const ShiftBlock& block, std::size_t begin,
                         std::size_t end, __m128i (&sums)[kBlockShifts]) {
  for (std::size_t c = begin; c < end; ++c) {
    const __m128i learned = _mm_load_si128(reinterpret_cast<const __m128i*>(bytes + c * kChunkBytes));
    for (std::size_t s = 0; s < kBlockShifts; ++s) {
      const std::size_t i = c * kBlockShifts + s;
      const __m128i compared = _mm_and_si128(learned, broadcast128(block.mask[i]));
      sums[s] = _mm_add_epi64(sums[s], _mm_sad_epu8(compared, broadcast128(block.view[i])));
    }
  }
}

}  // namespace

void smallestSadsOfArchitecture(const std::uint8_t* groups, std::size_t group_count,
                                const ShiftedViews& views, std::uint32_t* smallest) {
  constexpr std::size_t kPairs = kGroupLanes / 2;
  for (std::size_t pair = 0; pair < group_count * kPairs; ++pair) {
    const std::uint8_t* bytes =
        groups + pair / kPairs * views.group_chunks * kChunkBytes + pair % kPairs * 16;
    std::uint32_t least[2] = {std::numeric_limits<std::uint32_t>::max(),
                              std::numeric_limits<std::uint32_t>::max()};
    for (const ShiftBlock& block : views.blocks) {
      __m128i sums[kBlockShifts] = {_mm_setzero_si128(), _mm_setzero_si128(), _mm_setzero_si128(),
                                    _mm_setzero_si128()};
      addMasked128(bytes, block, block.begin, block.inner_begin, sums);
      const std::uint64_t* view = block.view.data() + block.inner_begin * kBlockShifts;
      for (std::size_t c = block.inner_begin; c < block.inner_end; ++c, view += kBlockShifts) {
        const __m128i learned = _mm_load_si128(reinterpret_cast<const __m128i*>(bytes + c * kChunkBytes));
        for (std::size_t s = 0; s < kBlockShifts; ++s) {
          sums[s] = _mm_add_epi64(sums[s], _mm_sad_epu8(learned, broadcast128(view[s])));
        }
      }
      addMasked128(bytes, block, block.inner_end, block.end, sums);
      for (const __m128i& sum : sums) {
        least[0] = std::min(least[0], static_cast<std::uint32_t>(_mm_cvtsi128_si32(sum)));
        least[1] = std::min(least[1], static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_srli_si128(sum, 8))));
      }
    }
    std::copy_n(least, 2, smallest + pair * 2);
  }
}

namespace {

__attribute__((target("avx2"))) inline __m256i broadcast256(const std::uint64_t& word) {
  return _mm256_set1_epi64x(static_cast<long long>(word));
}

__attribute__((target("avx2"))) inline void addMasked256(const std::uint8_t* bytes, const ShiftBlock& block,
                                                         std::size_t begin, std::size_t end,
                                                         __m256i (&sums)[kBlockShifts]) {
  for (std::size_t c = begin; c < end; ++c) {
    const __m256i learned = _mm256_load_si256(reinterpret_cast<const __m256i*>(bytes + c * kChunkBytes));
    for (std::size_t s = 0; s < kBlockShifts; ++s) {
      const std::size_t i = c * kBlockShifts + s;
      const __m256i compared = _mm256_and_si256(learned, broadcast256(block.mask[i]));
      sums[s] = _mm256_add_epi64(sums[s], _mm256_sad_epu8(compared, broadcast256(block.view[i])));
    }
  }
}

}  // namespace

__attribute__((target("avx2"))) void smallestSadsAvx2(const std::uint8_t* groups, std::size_t group_count,
                                                      const ShiftedViews& views, std::uint32_t* smallest) {
  const __m256i low_halves = _mm256_set_epi32(7, 7, 7, 7, 6, 4, 2, 0);
  for (std::size_t half = 0; half < group_count * 2; ++half) {
    const std::uint8_t* bytes = groups + half / 2 * views.group_chunks * kChunkBytes + half % 2 * 32;
    __m256i least = _mm256_set1_epi32(-1);
    for (const ShiftBlock& block : views.blocks) {
      __m256i sums[kBlockShifts] = {_mm256_setzero_si256(), _mm256_setzero_si256(), _mm256_setzero_si256(),
                                    _mm256_setzero_si256()};
      addMasked256(bytes, block, block.begin, block.inner_begin, sums);
      const std::uint64_t* view = block.view.data() + block.inner_begin * kBlockShifts;
      for (std::size_t c = block.inner_begin; c < block.inner_end; ++c, view += kBlockShifts) {
        const __m256i learned = _mm256_load_si256(reinterpret_cast<const __m256i*>(bytes + c * kChunkBytes));
        for (std::size_t s = 0; s < kBlockShifts; ++s) {
          sums[s] = _mm256_add_epi64(sums[s], _mm256_sad_epu8(learned, broadcast256(view[s])));
        }
      }
      addMasked256(bytes, block, block.inner_end, block.end, sums);
      for (const __m256i& sum : sums) least = _mm256_min_epu32(least, sum);
    }
    _mm_storeu_si128(reinterpret_cast<__m128i*>(smallest + half * 4),
                     _mm256_castsi256_si128(_mm256_permutevar8x32_epi32(least, low_halves)));
  }
}

namespace {

__attribute__((target("avx512f,avx512bw"))) inline __m512i broadcast512(const std::uint64_t& word) {
  return _mm512_set1_epi64(static_cast<long long>(word));
}

/// Adds 16 bits each where sums stay below 2^16, which leaves the execution unit of sad alone.
template <bool kNarrow>
__attribute__((target("avx512f,avx512bw"))) inline __m512i plusSad512(__m512i sum, __m512i learned,
                                                                      const std::uint64_t& view) {
  const __m512i sad = _mm512_sad_epu8(learned, broadcast512(view));
  return kNarrow ? _mm512_adds_epu16(sum, sad) : _mm512_add_epi64(sum, sad);
}

template <bool kNarrow>
__attribute__((target("avx512f,avx512bw"))) inline void addMasked512(const std::uint8_t* bytes,
                                                                     const ShiftBlock& block,
                                                                     std::size_t begin, std::size_t end,
                                                                     __m512i (&sums)[kBlockShifts]) {
  for (std::size_t c = begin; c < end; ++c) {
    const __m512i learned = _mm512_load_si512(bytes + c * kChunkBytes);
    for (std::size_t s = 0; s < kBlockShifts; ++s) {
      const std::size_t i = c * kBlockShifts + s;
      const __m512i compared = _mm512_and_si512(learned, broadcast512(block.mask[i]));
      sums[s] = plusSad512<kNarrow>(sums[s], compared, block.view[i]);
    }
  }
}

template <bool kNarrow>
__attribute__((target("avx512f,avx512bw"))) void smallestSads512(const std::uint8_t* groups,
                                                                 std::size_t group_count,
                                                                 const ShiftedViews& views,
                                                                 std::uint32_t* smallest) {
  // The forms with a (full) mask: GCC 12 takes the plain ones for uses of an uninitialised variable.
  for (std::size_t group = 0; group < group_count; ++group) {
    const std::uint8_t* bytes = groups + group * views.group_chunks * kChunkBytes;
    __m512i least = _mm512_set1_epi64(-1);
    for (const ShiftBlock& block : views.blocks) {
      __m512i sums[kBlockShifts] = {_mm512_setzero_si512(), _mm512_setzero_si512(), _mm512_setzero_si512(),
                                    _mm512_setzero_si512()};
      addMasked512<kNarrow>(bytes, block, block.begin, block.inner_begin, sums);
      const std::uint64_t* view = block.view.data() + block.inner_begin * kBlockShifts;
      for (std::size_t c = block.inner_begin; c < block.inner_end; ++c, view += kBlockShifts) {
        const __m512i learned = _mm512_load_si512(bytes + c * kChunkBytes);
        for (std::size_t s = 0; s < kBlockShifts; ++s) {
          sums[s] = plusSad512<kNarrow>(sums[s], learned, view[s]);
        }
      }
      addMasked512<kNarrow>(bytes, block, block.inner_end, block.end, sums);
      for (const __m512i& sum : sums) least = _mm512_maskz_min_epu32(0xffff, least, sum);
    }
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(smallest + group * kGroupLanes),
                        _mm512_maskz_cvtepi64_epi32(0xff, least));
  }
}

}  // namespace

void smallestSadsAvx512(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                        std::uint32_t* smallest) {
  const bool narrow = views.most_compared * 255 <= std::numeric_limits<std::uint16_t>::max();
  (narrow ? smallestSads512<true> : smallestSads512<false>)(groups, group_count, views, smallest);
}

#elif defined(__aarch64__)

void smallestSadsOfArchitecture(const std::uint8_t* groups, std::size_t group_count,
                                const ShiftedViews& views, std::uint32_t* smallest) {
  for (std::size_t lane = 0; lane < group_count * kGroupLanes; ++lane) {
    const std::uint8_t* bytes =
        groups + lane / kGroupLanes * views.group_chunks * kChunkBytes + lane % kGroupLanes * 8;
    std::uint32_t least = std::numeric_limits<std::uint32_t>::max();
    for (const ShiftBlock& block : views.blocks) {
      uint32x4_t sums[kBlockShifts] = {vdupq_n_u32(0), vdupq_n_u32(0), vdupq_n_u32(0), vdupq_n_u32(0)};
      for (std::size_t c = block.begin; c < block.end; ++c) {
        const uint8x8_t learned = vld1_u8(bytes + c * kChunkBytes);
        for (std::size_t s = 0; s < kBlockShifts; ++s) {
          const std::size_t i = c * kBlockShifts + s;
          const uint8x8_t compared = vand_u8(learned, vcreate_u8(block.mask[i]));
          sums[s] = vpadalq_u16(sums[s], vabdl_u8(compared, vcreate_u8(block.view[i])));
        }
      }
      for (const uint32x4_t& sum : sums) least = std::min(least, vaddvq_u32(sum));
    }
    smallest[lane] = least;
  }
}

#else

void smallestSadsOfArchitecture(const std::uint8_t* groups, std::size_t group_count,
                                const ShiftedViews& views, std::uint32_t* smallest) {
  smallestSadsScalar(groups, group_count, views, smallest);
}

#endif

}  // namespace ratslam
