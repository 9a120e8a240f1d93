/// Scalar products of many vectors of bytes with a few queries. They are compiled for several instruction sets, one of
/// which is selected at run time. All sums are whole numbers, so every level gives the same results.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ratslam/simd/simd_level.h"

namespace ratslam {

constexpr std::size_t kByteQuantum = 64;      ///< lengths must be multiples of this
constexpr std::size_t kLargestLength = 8192;  ///< with longer vectors sums could overflow 32 bits

/// products[q * stride + i] = sum over k of (vectors[i][k] - 128) queries[q][k].
/// @param vectors `count` consecutive vectors of `length` bytes
/// @param queries `query_count` consecutive vectors of `length` numbers from -127 to 127
using ByteProducts = void (*)(const std::uint8_t* vectors, std::size_t count, std::size_t length,
                              const std::int8_t* queries, std::size_t query_count, std::int32_t* products,
                              std::size_t stride);

/// @throws std::invalid_argument if this processor lacks the level.
ByteProducts byteProductsFor(SimdLevel level);

}  // namespace ratslam
