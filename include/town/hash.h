/// Random numbers of the town: integer hashes, so that one seed gives the same town on every machine (the
/// standard library's distributions are free to differ from one implementation to the next). The mixing
/// function is the finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
#pragma once

#include <cstdint>

namespace ratslam {

/// Spreads every bit of the argument over all bits of the result.
constexpr std::uint64_t mixBits(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

/// One hash of several keys; their order matters.
constexpr std::uint64_t hashOf(std::uint64_t a, std::uint64_t b) { return mixBits(mixBits(a) ^ b); }
constexpr std::uint64_t hashOf(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  return mixBits(hashOf(a, b) ^ c);
}

/// The hash as a number in [0, 1).
constexpr double unitFromHash(std::uint64_t hash) { return static_cast<double>(hash >> 11) * 0x1.0p-53; }

/// About normally distributed with mean 0 and standard deviation 1, within +-3.5: the sum of four uniform
/// 16-bit numbers (Irwin-Hall), exact in every floating point arithmetic.
constexpr double normalFromHash(std::uint64_t hash) {
  const std::uint64_t sum =
      (hash & 0xFFFF) + ((hash >> 16) & 0xFFFF) + ((hash >> 32) & 0xFFFF) + ((hash >> 48) & 0xFFFF);
  return (static_cast<double>(sum) - 131070.0) * (1.7320508075688772 / 65536.0);
}

/// A sequence of random numbers for one object of the town. Each draw is a statement of its own, or an element of a list
/// in braces: C++ leaves open in which order the arguments of a call and the operands of a sum are evaluated.
class HashStream {
 public:
  explicit constexpr HashStream(std::uint64_t seed) : state_(mixBits(seed)) {}
  constexpr std::uint64_t next() { return mixBits(state_++); }
  constexpr double uniform() { return unitFromHash(next()); }  ///< in [0, 1)
  constexpr double range(double low, double high) { return low + (high - low) * uniform(); }
  constexpr int index(int count) { return static_cast<int>(uniform() * count); }  ///< in [0, count)
  constexpr bool chance(double probability) { return uniform() < probability; }
  constexpr double normal() { return normalFromHash(next()); }  ///< mean 0, standard deviation 1

 private:
  std::uint64_t state_;
};

}  // namespace ratslam
