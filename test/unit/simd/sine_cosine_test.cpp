#include "ratslam/simd/sine_cosine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

/// Angles of all sizes up to the largest that is reduced, near multiples of pi/4 too, and some beyond.
std::vector<double> angles() {
  std::vector<double> angles{0.0, std::numeric_limits<double>::denorm_min(), 1e-300, 1e-20, 1e-9};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> turn(0.0, 2.0 * kPi);
  std::uniform_real_distribution<double> exponent(-30.0, std::log2(kLargestReducedAngle));
  for (int i = 0; i < 100000; ++i) angles.push_back(turn(random));
  for (int i = 0; i < 100000; ++i) angles.push_back(std::exp2(exponent(random)));
  for (int k = 0; k < 1270000; k += k < 1000 ? 1 : 97) {
    for (const int ulps : {-2, -1, 0, 1, 2}) {
      const double multiple = k * (kPi / 4.0);
      angles.push_back(std::abs(multiple + ulps * (std::nextafter(multiple, 1e9) - multiple)));
    }
  }
  angles.insert(angles.end(), {kLargestReducedAngle, 1.001e6, 1e10, 1e300});
  return angles;
}

bool sameBits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Difference from the true value in units in the last place.
double ulps(double value, long double truth) {
  const auto rounded = static_cast<double>(truth);
  const double unit = std::nextafter(std::abs(rounded), 2.0 * std::abs(rounded) + 1.0) - std::abs(rounded);
  return static_cast<double>(std::abs(static_cast<long double>(value) - truth)) / unit;
}

TEST(SineCosine, IsWithinAUnitInTheLastPlaceOfTheLibrary) {
  const bool finer = std::numeric_limits<long double>::digits > std::numeric_limits<double>::digits + 8;
  double worst = 0.0;
  for (const double angle : angles()) {
    const SineCosine found = sineCosine(angle);
    ASSERT_LE(ulps(found.sine, std::sin(angle)), 1.0) << angle;
    ASSERT_LE(ulps(found.cosine, std::cos(angle)), 1.0) << angle;
    if (!finer || angle > kLargestReducedAngle) continue;
    worst = std::max(worst, ulps(found.sine, std::sin(static_cast<long double>(angle))));
    worst = std::max(worst, ulps(found.cosine, std::cos(static_cast<long double>(angle))));
  }
  EXPECT_LE(worst, 0.8);
  RecordProperty("worst", std::to_string(worst));
}

TEST(SineCosine, IsOddAndEven) {
  for (const double angle : angles()) {
    ASSERT_EQ(sineCosine(-angle).sine, -sineCosine(angle).sine) << angle;
    ASSERT_TRUE(sameBits(sineCosine(-angle).cosine, sineCosine(angle).cosine)) << angle;
  }
}

TEST(SineCosine, OfManyAnglesHasTheSameBitsAtEveryInstructionSet) {
  const std::vector<double> all = angles();
  for (const SimdLevel level : availableSimdLevels()) {
    // From different places on and in different numbers, so that lanes and remainders change.
    for (std::size_t first = 0, count = 0; first + count <= all.size(); first += count, count = first % 67) {
      std::vector<double> sines(count + 1, 7.0);
      std::vector<double> cosines(count + 1, 7.0);
      sinesCosinesFor(level)(all.data() + first, count, sines.data(), cosines.data());
      for (std::size_t i = 0; i < count; ++i) {
        const SineCosine expected = sineCosine(all[first + i]);
        ASSERT_TRUE(sameBits(sines[i], expected.sine)) << all[first + i];
        ASSERT_TRUE(sameBits(cosines[i], expected.cosine)) << all[first + i];
      }
      ASSERT_EQ(sines[count], 7.0);
      ASSERT_EQ(cosines[count], 7.0);
      if (count == 0) ++first;
    }
  }
}

TEST(SineCosine, OfNoNumberIsNone) {
  for (const double angle :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(std::isnan(sineCosine(angle).sine));
    EXPECT_TRUE(std::isnan(sineCosine(angle).cosine));
  }
}

// Whatever the C library, the processor and the compiler.
TEST(SineCosine, HasTheseBits) {
  EXPECT_EQ(sineCosine(0.5).sine, 0x1.eaee8744b05fp-2);
  EXPECT_EQ(sineCosine(2.0).cosine, -0x1.aa22657537205p-2);
  EXPECT_EQ(sineCosine(-3.1).sine, -0x1.54a0f8298102ep-5);
  EXPECT_EQ(sineCosine(100.25).cosine, 0x1.ebec72ba6b0ecp-1);
  EXPECT_EQ(sineCosine(987654.3).sine, 0x1.903d4ac3d425ep-2);
}

}  // namespace
}  // namespace ratslam
