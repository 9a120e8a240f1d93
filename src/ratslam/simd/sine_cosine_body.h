/// Sines and cosines of many angles, see level_body.h.

constexpr std::size_t kLanes = RATSLAM_REGISTER_BYTES / 8;

typedef double Doubles __attribute__((vector_size(8 * kLanes)));
typedef double LooseDoubles __attribute__((vector_size(8 * kLanes), aligned(8), may_alias));
typedef std::int64_t Words __attribute__((vector_size(8 * kLanes), may_alias));
typedef std::int64_t LooseWords __attribute__((vector_size(8 * kLanes), aligned(8), may_alias));

/// Clears `reduced` in lanes with angles beyond kLargestReducedAngle, whose results are invalid. Arguments are in memory,
/// because the calling convention of vectors depends on the target.
inline void sinesCosinesOfRegister(const double* angles, double* sines, double* cosines, Words& reduced) {
  // pi/2 in parts of 33, 33 and 53 bits: multiples of the first two are exact up to 2^20.
  constexpr double kTwoByPi = 0x1.45f306dc9c883p-1;
  constexpr double kHalfPi1 = 0x1.921fb544p+0;
  constexpr double kHalfPi2 = 0x1.0b4611a6p-34;
  constexpr double kHalfPi3 = 0x1.3198a2e037073p-69;
  // Adding it to a small number puts the nearest integer into the last bits.
  constexpr double kToInteger = 0x1.8p+52;

  const Doubles angle = *reinterpret_cast<const LooseDoubles*>(angles);
  reduced &= (angle <= kLargestReducedAngle) & (angle >= -kLargestReducedAngle);
  const Doubles shifted = angle * kTwoByPi + kToInteger;
  const Words quarter = reinterpret_cast<const Words&>(shifted);  // its last 2 bits
  const Doubles quarters = shifted - kToInteger;

  // x + rest = angle - quarters * pi/2; `lost` is the rounding error of `most`.
  const Doubles first = angle - quarters * kHalfPi1;
  const Doubles second = quarters * kHalfPi2;
  const Doubles most = first - second;
  const Doubles took = first - most;
  const Doubles lost = (first - (most + took)) - (second - took);
  const Doubles correction = lost - quarters * kHalfPi3;
  const Doubles x = most + correction;
  const Doubles rest = (most - x) + correction;

  const Doubles z = x * x;
  const Doubles sine_series =
      -1.0 / 6 +
      z * (1.0 / 120 +
           z * (-1.0 / 5040 +
                z * (1.0 / 362880 +
                     z * (-1.0 / 39916800 + z * (1.0 / 6227020800 + z * (-1.0 / 1307674368000 +
                                                                         z * (1.0 / 355687428096000)))))));
  const Doubles cosine_series =
      1.0 / 24 +
      z * (-1.0 / 720 + z * (1.0 / 40320 + z * (-1.0 / 3628800 +
                                                z * (1.0 / 479001600 + z * (-1.0 / 87178291200 +
                                                                            z * (1.0 / 20922789888000))))));
  const Doubles half = 0.5 * z;
  const Doubles sine = x + (x * z * sine_series + rest * (1.0 - half));
  const Doubles near_one = 1.0 - half;
  const Doubles cosine = near_one + (((1.0 - near_one) - half) + (z * z * cosine_series - x * rest));

  // Every quarter turn takes (cosine, sine) to (-sine, cosine).
  const Words& sine_bits = reinterpret_cast<const Words&>(sine);
  const Words& cosine_bits = reinterpret_cast<const Words&>(cosine);
  const Words odd = -(quarter & 1);
  const Words sine_sign = (quarter & 2) << 62;
  const Words cosine_sign = ((quarter + 1) & 2) << 62;
  *reinterpret_cast<LooseWords*>(sines) = ((sine_bits & ~odd) | (cosine_bits & odd)) ^ sine_sign;
  *reinterpret_cast<LooseWords*>(cosines) = ((cosine_bits & ~odd) | (sine_bits & odd)) ^ cosine_sign;
}

void sinesCosines(const double* angles, std::size_t count, double* sines, double* cosines) {
  Words reduced = ~Words{};
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    sinesCosinesOfRegister(angles + i, sines + i, cosines + i, reduced);
  }
  if (i < count) {
    double padded[kLanes] = {};
    double padded_sines[kLanes];
    double padded_cosines[kLanes];
    std::copy(angles + i, angles + count, padded);
    sinesCosinesOfRegister(padded, padded_sines, padded_cosines, reduced);
    std::copy_n(padded_sines, count - i, sines + i);
    std::copy_n(padded_cosines, count - i, cosines + i);
  }
  std::int64_t all_reduced = -1;
  for (std::size_t lane = 0; lane < kLanes; ++lane) all_reduced &= reduced[lane];
  if (all_reduced != 0) return;
  for (i = 0; i < count; ++i) {
    if (std::abs(angles[i]) <= kLargestReducedAngle) continue;
    sines[i] = std::sin(angles[i]);
    cosines[i] = std::cos(angles[i]);
  }
}
