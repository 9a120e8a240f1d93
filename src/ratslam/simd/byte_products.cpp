#include "ratslam/simd/byte_products.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace ratslam {
namespace {

constexpr int kBias = 128;
constexpr std::size_t kTogether = 5;  // queries that share one pass over a vector

std::int32_t sumOf(const std::int8_t* query, std::size_t length) {
  std::int32_t sum = 0;
  for (std::size_t k = 0; k < length; ++k) sum += query[k];
  return sum;
}

void productsPortable(const std::uint8_t* vectors, std::size_t count, std::size_t length,
                      const std::int8_t* queries, std::size_t query_count, std::int32_t* products,
                      std::size_t stride) {
  for (std::size_t i = 0; i < count; ++i, vectors += length) {
    for (std::size_t q = 0; q < query_count; ++q) {
      const std::int8_t* query = queries + q * length;
      std::int32_t sum = 0;
      for (std::size_t k = 0; k < length; ++k) sum += (vectors[k] - kBias) * query[k];
      products[q * stride + i] = sum;
    }
  }
}

#if defined(__x86_64__)

template <std::size_t kQueries>
__attribute__((target("avx2"))) void someAvx2(const std::uint8_t* vectors, std::size_t count,
                                              std::size_t length, const std::int16_t* queries,
                                              std::int32_t* products, std::size_t stride) {
  const __m256i bias = _mm256_set1_epi16(kBias);
  for (std::size_t i = 0; i < count; ++i, vectors += length) {
    __m256i sums[kQueries];
    for (__m256i& sum : sums) sum = _mm256_setzero_si256();
    for (std::size_t k = 0; k < length; k += 16) {
      const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(vectors + k));
      const __m256i words = _mm256_sub_epi16(_mm256_cvtepu8_epi16(bytes), bias);
      for (std::size_t q = 0; q < kQueries; ++q) {
        const __m256i query = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(queries + q * length + k));
        sums[q] = _mm256_add_epi32(sums[q], _mm256_madd_epi16(words, query));
      }
    }
    for (std::size_t q = 0; q < kQueries; ++q) {
      __m128i sum = _mm_add_epi32(_mm256_castsi256_si128(sums[q]), _mm256_extracti128_si256(sums[q], 1));
      sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0x4e));
      sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0xb1));
      products[q * stride + i] = _mm_cvtsi128_si32(sum);
    }
  }
}

__attribute__((target("avx2"))) void productsAvx2(const std::uint8_t* vectors, std::size_t count,
                                                  std::size_t length, const std::int8_t* queries,
                                                  std::size_t query_count, std::int32_t* products,
                                                  std::size_t stride) {
  const std::vector<std::int16_t> wide(queries, queries + query_count * length);
  std::size_t q = 0;
  for (; q + kTogether <= query_count; q += kTogether) {
    someAvx2<kTogether>(vectors, count, length, wide.data() + q * length, products + q * stride, stride);
  }
  for (; q < query_count; ++q) {
    someAvx2<1>(vectors, count, length, wide.data() + q * length, products + q * stride, stride);
  }
}

/// 64 products of bytes per instruction. The vectors' bytes are unsigned, and the bias is subtracted at the end.
template <std::size_t kQueries>
__attribute__((target("avx512f,avx512bw,avx512vnni"))) void someVnni(const std::uint8_t* vectors,
                                                                     std::size_t count, std::size_t length,
                                                                     const std::int8_t* queries,
                                                                     std::int32_t* products,
                                                                     std::size_t stride) {
  std::int32_t biases[kQueries];
  for (std::size_t q = 0; q < kQueries; ++q) biases[q] = kBias * sumOf(queries + q * length, length);
  for (std::size_t i = 0; i < count; ++i, vectors += length) {
    __m512i sums[kQueries];
    for (__m512i& sum : sums) sum = _mm512_setzero_si512();
    for (std::size_t k = 0; k < length; k += 64) {
      const __m512i bytes = _mm512_loadu_si512(vectors + k);
      for (std::size_t q = 0; q < kQueries; ++q) {
        sums[q] = _mm512_dpbusd_epi32(sums[q], bytes, _mm512_loadu_si512(queries + q * length + k));
      }
    }
    for (std::size_t q = 0; q < kQueries; ++q) {
      alignas(64) std::int32_t lanes[16];
      _mm512_store_si512(lanes, sums[q]);
      std::int32_t sum = 0;
      for (const std::int32_t lane : lanes) sum += lane;
      products[q * stride + i] = sum - biases[q];
    }
  }
}

void productsVnni(const std::uint8_t* vectors, std::size_t count, std::size_t length,
                  const std::int8_t* queries, std::size_t query_count, std::int32_t* products,
                  std::size_t stride) {
  std::size_t q = 0;
  for (; q + kTogether <= query_count; q += kTogether) {
    someVnni<kTogether>(vectors, count, length, queries + q * length, products + q * stride, stride);
  }
  for (; q < query_count; ++q) {
    someVnni<1>(vectors, count, length, queries + q * length, products + q * stride, stride);
  }
}

#endif

}  // namespace

ByteProducts byteProductsFor(SimdLevel level) {
  const std::vector<SimdLevel> levels = availableSimdLevels();
  if (std::find(levels.begin(), levels.end(), level) == levels.end()) {
    throw std::invalid_argument("view search: this processor lacks the requested instruction set");
  }
#if defined(__x86_64__)
  if (level == SimdLevel::kAvx512 && __builtin_cpu_supports("avx512vnni")) return productsVnni;
  if (level == SimdLevel::kAvx512 || level == SimdLevel::kAvx2) return productsAvx2;
#endif
  return productsPortable;
}

}  // namespace ratslam
