#include "sad_kernels.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>

#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace ratslam {
namespace {

std::uint32_t chunkSad(const std::uint8_t* bytes, std::uint64_t view, std::uint64_t mask) {
  std::uint64_t masked = 0;
  std::memcpy(&masked, bytes, sizeof masked);
  masked &= mask;
  std::uint32_t sum = 0;
  for (int bit = 0; bit < 64; bit += 8) {
    const int difference = static_cast<int>((masked >> bit) & 255U) - static_cast<int>((view >> bit) & 255U);
    sum += static_cast<std::uint32_t>(difference < 0 ? -difference : difference);
  }
  return sum;
}

void smallestSadsScalar(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                        std::uint32_t* smallest) {
  for (std::size_t lane = 0; lane < group_count * kGroupLanes; ++lane) {
    const std::uint8_t* bytes =
        groups + lane / kGroupLanes * views.group_chunks * kChunkBytes + lane % kGroupLanes * 8;
    std::uint32_t least = std::numeric_limits<std::uint32_t>::max();
    for (std::size_t i = 0; i < views.shift_count; ++i) {
      const ShiftedView& shift = views.shifts[i];
      std::uint32_t sum = chunkSad(bytes + shift.head.chunk * kChunkBytes, shift.head.view, shift.head.mask) +
                          chunkSad(bytes + shift.tail.chunk * kChunkBytes, shift.tail.view, shift.tail.mask);
      for (std::size_t c = 0; c < shift.middle_count; ++c) {
        sum += chunkSad(bytes + (shift.middle_chunk + c) * kChunkBytes, shift.middle_view[c], ~std::uint64_t{0});
      }
      least = std::min(least, sum);
    }
    smallest[lane] = least;
  }
}

#if defined(__x86_64__)

inline __m128i masked128(const std::uint8_t* bytes, const MaskedChunk& part) {
  const __m128i learned = _mm_load_si128(reinterpret_cast<const __m128i*>(bytes + part.chunk * kChunkBytes));
  const __m128i mask = _mm_set1_epi64x(static_cast<long long>(part.mask));
  return _mm_sad_epu8(_mm_and_si128(learned, mask), _mm_set1_epi64x(static_cast<long long>(part.view)));
}

void smallestSadsSse2(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                      std::uint32_t* smallest) {
  constexpr std::size_t kPairs = kGroupLanes / 2;
  for (std::size_t pair = 0; pair < group_count * kPairs; ++pair) {
    const std::uint8_t* bytes = groups + pair / kPairs * views.group_chunks * kChunkBytes + pair % kPairs * 16;
    std::uint32_t least[2] = {std::numeric_limits<std::uint32_t>::max(),
                              std::numeric_limits<std::uint32_t>::max()};
    for (std::size_t i = 0; i < views.shift_count; ++i) {
      const ShiftedView& shift = views.shifts[i];
      __m128i sum = _mm_add_epi64(masked128(bytes, shift.head), masked128(bytes, shift.tail));
      const std::uint8_t* middle = bytes + shift.middle_chunk * kChunkBytes;
      for (std::size_t c = 0; c < shift.middle_count; ++c) {
        const __m128i learned = _mm_load_si128(reinterpret_cast<const __m128i*>(middle + c * kChunkBytes));
        const __m128i view = _mm_set1_epi64x(static_cast<long long>(shift.middle_view[c]));
        sum = _mm_add_epi64(sum, _mm_sad_epu8(learned, view));
      }
      least[0] = std::min(least[0], static_cast<std::uint32_t>(_mm_cvtsi128_si32(sum)));
      least[1] = std::min(least[1], static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_srli_si128(sum, 8))));
    }
    std::copy_n(least, 2, smallest + pair * 2);
  }
}

__attribute__((target("avx2"))) inline __m256i masked256(const std::uint8_t* bytes, const MaskedChunk& part) {
  const __m256i learned = _mm256_load_si256(reinterpret_cast<const __m256i*>(bytes + part.chunk * kChunkBytes));
  const __m256i mask = _mm256_set1_epi64x(static_cast<long long>(part.mask));
  return _mm256_sad_epu8(_mm256_and_si256(learned, mask),
                         _mm256_set1_epi64x(static_cast<long long>(part.view)));
}

__attribute__((target("avx2"))) void smallestSadsAvx2(const std::uint8_t* groups, std::size_t group_count,
                                                      const ShiftedViews& views, std::uint32_t* smallest) {
  const __m256i low_halves = _mm256_set_epi32(7, 7, 7, 7, 6, 4, 2, 0);
  for (std::size_t half = 0; half < group_count * 2; ++half) {
    const std::uint8_t* bytes = groups + half / 2 * views.group_chunks * kChunkBytes + half % 2 * 32;
    __m256i least = _mm256_set1_epi32(-1);
    for (std::size_t i = 0; i < views.shift_count; ++i) {
      const ShiftedView& shift = views.shifts[i];
      __m256i sum = _mm256_add_epi64(masked256(bytes, shift.head), masked256(bytes, shift.tail));
      const std::uint8_t* middle = bytes + shift.middle_chunk * kChunkBytes;
      for (std::size_t c = 0; c < shift.middle_count; ++c) {
        const __m256i learned =
            _mm256_load_si256(reinterpret_cast<const __m256i*>(middle + c * kChunkBytes));
        const __m256i view = _mm256_set1_epi64x(static_cast<long long>(shift.middle_view[c]));
        sum = _mm256_add_epi64(sum, _mm256_sad_epu8(learned, view));
      }
      least = _mm256_min_epu32(least, sum);
    }
    _mm_storeu_si128(reinterpret_cast<__m128i*>(smallest + half * 4),
                     _mm256_castsi256_si128(_mm256_permutevar8x32_epi32(least, low_halves)));
  }
}

__attribute__((target("avx512f,avx512bw"))) inline __m512i masked512(const std::uint8_t* bytes,
                                                                     const MaskedChunk& part) {
  const __m512i learned = _mm512_load_si512(bytes + part.chunk * kChunkBytes);
  const __m512i mask = _mm512_set1_epi64(static_cast<long long>(part.mask));
  return _mm512_sad_epu8(_mm512_and_si512(learned, mask),
                         _mm512_set1_epi64(static_cast<long long>(part.view)));
}

__attribute__((target("avx512f,avx512bw"))) void smallestSadsAvx512(const std::uint8_t* groups,
                                                                    std::size_t group_count,
                                                                    const ShiftedViews& views,
                                                                    std::uint32_t* smallest) {
  for (std::size_t group = 0; group < group_count; ++group) {
    const std::uint8_t* bytes = groups + group * views.group_chunks * kChunkBytes;
    // The forms with a (full) mask: GCC 12 takes the plain ones for uses of an uninitialised variable.
    __m512i least = _mm512_set1_epi64(-1);
    for (std::size_t i = 0; i < views.shift_count; ++i) {
      const ShiftedView& shift = views.shifts[i];
      __m512i sum = _mm512_add_epi64(masked512(bytes, shift.head), masked512(bytes, shift.tail));
      const std::uint8_t* middle = bytes + shift.middle_chunk * kChunkBytes;
      for (std::size_t c = 0; c < shift.middle_count; ++c) {
        const __m512i view = _mm512_set1_epi64(static_cast<long long>(shift.middle_view[c]));
        sum = _mm512_add_epi64(sum, _mm512_sad_epu8(_mm512_load_si512(middle + c * kChunkBytes), view));
      }
      least = _mm512_maskz_min_epu32(0xffff, least, sum);
    }
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(smallest + group * kGroupLanes),
                        _mm512_maskz_cvtepi64_epi32(0xff, least));
  }
}

#elif defined(__aarch64__)

inline uint32x4_t addSad(uint32x4_t sum, const std::uint8_t* bytes, std::uint64_t view, std::uint64_t mask) {
  const uint8x8_t learned = vand_u8(vld1_u8(bytes), vcreate_u8(mask));
  return vpadalq_u16(sum, vabdl_u8(learned, vcreate_u8(view)));
}

void smallestSadsNeon(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                      std::uint32_t* smallest) {
  for (std::size_t lane = 0; lane < group_count * kGroupLanes; ++lane) {
    const std::uint8_t* bytes =
        groups + lane / kGroupLanes * views.group_chunks * kChunkBytes + lane % kGroupLanes * 8;
    std::uint32_t least = std::numeric_limits<std::uint32_t>::max();
    for (std::size_t i = 0; i < views.shift_count; ++i) {
      const ShiftedView& shift = views.shifts[i];
      uint32x4_t sum = vdupq_n_u32(0);
      sum = addSad(sum, bytes + shift.head.chunk * kChunkBytes, shift.head.view, shift.head.mask);
      sum = addSad(sum, bytes + shift.tail.chunk * kChunkBytes, shift.tail.view, shift.tail.mask);
      const std::uint8_t* middle = bytes + shift.middle_chunk * kChunkBytes;
      for (std::size_t c = 0; c < shift.middle_count; ++c) {
        sum = vpadalq_u16(sum, vabdl_u8(vld1_u8(middle + c * kChunkBytes), vcreate_u8(shift.middle_view[c])));
      }
      least = std::min(least, vaddvq_u32(sum));
    }
    smallest[lane] = least;
  }
}

#endif

}  // namespace

std::vector<SimdLevel> availableSimdLevels() {
  std::vector<SimdLevel> levels{SimdLevel::kScalar};
#if defined(__x86_64__)
  levels.push_back(SimdLevel::kSse2);  // part of every x86-64
  if (__builtin_cpu_supports("avx2")) levels.push_back(SimdLevel::kAvx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw")) {
    levels.push_back(SimdLevel::kAvx512);
  }
#elif defined(__aarch64__)
  levels.push_back(SimdLevel::kNeon);  // part of every arm64
#endif
  return levels;
}

SmallestSads smallestSadsFor(SimdLevel level) {
  const std::vector<SimdLevel> levels = availableSimdLevels();
  if (std::find(levels.begin(), levels.end(), level) == levels.end()) {
    throw std::invalid_argument("template search: this processor lacks the requested instruction set");
  }
  switch (level) {
#if defined(__x86_64__)
    case SimdLevel::kSse2:
      return smallestSadsSse2;
    case SimdLevel::kAvx2:
      return smallestSadsAvx2;
    case SimdLevel::kAvx512:
      return smallestSadsAvx512;
#elif defined(__aarch64__)
    case SimdLevel::kNeon:
      return smallestSadsNeon;
#endif
    default:
      return smallestSadsScalar;
  }
}

}  // namespace ratslam
