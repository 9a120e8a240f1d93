/// Scalar products of many vectors of bytes with a few, compiled for several instruction sets and chosen at
/// run time. All sums are whole numbers: every level gives the same.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ratslam/simd/simd_level.h"

namespace ratslam {

constexpr std::size_t kByteQuantum = 64;      ///< lengths are multiples of this
constexpr std::size_t kLargestLength = 8192;  ///< so that no sum overflows 32 bits

/// products[q * stride + i] = sum over k of (vectors[i][k] - 128) queries[q][k].
/// @param vectors `count` of them, each `length` bytes after the last
/// @param queries `query_count` of them, each `length` bytes after the last, from -127 to 127
using ByteProducts = void (*)(const std::uint8_t* vectors, std::size_t count, std::size_t length,
                              const std::int8_t* queries, std::size_t query_count, std::int32_t* products,
                              std::size_t stride);

/// @throws std::invalid_argument where this processor lacks the level.
ByteProducts byteProductsFor(SimdLevel level);

}  // namespace ratslam
