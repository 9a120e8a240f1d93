/// The fast network equals the plain one: packets that travel, cross every face, split, merge, fill the
/// network.
#include <gtest/gtest.h>

#include <random>

#include "against_oracle.h"
#include "ratslam/common/stamp.h"
#include "reference_data.h"

namespace ratslam {
namespace {

constexpr double kPerStep = 1e-12;

/// Both networks, given the same input.
class Twins {
 public:
  explicit Twins(const PoseCellParams& params) : params_(params), fast(params), plain(params) {}

  void step(double distance, double rotation) {
    fast.step(distance, rotation);
    plain.step(distance, rotation);
  }
  void inject(const PoseCell& cell, double energy) {
    fast.inject(cell, energy);
    plain.inject(
        {static_cast<double>(cell.column), static_cast<double>(cell.row), static_cast<double>(cell.layer)},
        energy);
  }
  double difference() const { return largestDifference(fast.activity(), plain); }
  /// The estimate jumps between packets of equal height on a difference in the last bit: compared only where
  /// the most active cell stands out.
  double estimateDifference() const { return largestDifference(fast.estimate(), plain.estimate(), params_); }

 private:
  PoseCellParams params_;

 public:
  PoseCellNetwork fast;
  oracle::Network plain;
};

struct Case {
  const char* name;
  PoseCellParams params;
};

std::vector<Case> cases() {
  std::vector<Case> all{{"default", {}},         {"rat", sized(11, 36)}, {"one", sized(1, 1)},
                        {"two", sized(2, 2)},    {"ring", sized(1, 36)}, {"plane", sized(12, 1)},
                        {"small", sized(5, 4)},  {"flat", sized(33, 3)}, {"tall", sized(4, 50)},
                        {"prime", sized(23, 17)}};
  PoseCellParams params = sized(18, 20);
  params.openratslam_corner = false;
  all.push_back({"torus", params});
  params.excitation_var_th = 0.6;
  params.inhibition_var_th = 3.0;
  all.push_back({"anisotropic", params});
  params.excitation_dim = 1;
  params.inhibition_dim = 1;
  params.inhibition_var = 0.5;
  all.push_back({"points", params});
  params.excitation_dim = 9;
  params.inhibition_dim = 13;
  all.push_back({"wide", params});
  params = sized(20, 18);
  params.global_inhibition = 0.0;
  all.push_back({"uninhibited", params});
  params.global_inhibition = 0.4;
  all.push_back({"dying", params});
  return all;
}

class AgainstOracle : public testing::TestWithParam<Case> {};

TEST_P(AgainstOracle, EqualUnderRandomInput) {
  const PoseCellParams& params = GetParam().params;
  Twins twins(params);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int step = 0; step < 60; ++step) {
    const double reach = step % 10 == 9 ? 4.0 : 1.0;  // now and then several cells at once
    const double turn = step % 15 == 14 ? 40.0 : 0.3;
    twins.step(reach * uniform(random), turn * uniform(random));
    ASSERT_LT(twins.difference(), kPerStep) << "step " << step;
    expectSound(twins.fast);
    if (step % 3 == 0) {
      const auto anywhere = [&](int size) {
        return static_cast<int>((uniform(random) + 1.0) / 2.0 * size) % size;
      };
      twins.inject({anywhere(params.n_xy), anywhere(params.n_xy), anywhere(params.n_th)}, 0.15);
      ASSERT_LT(twins.difference(), kPerStep) << "step " << step;
      expectSound(twins.fast);
    }
  }
  EXPECT_EQ(twins.fast.reseeds(), twins.plain.reseeds());
}

TEST_P(AgainstOracle, EqualFromActivityEverywhere) {
  const PoseCellParams& params = GetParam().params;
  ActivityGrid lit(params.n_xy, params.n_th);
  lit.cover({Box{Span{0, params.n_xy}, Span{0, params.n_xy}, Span{0, params.n_th}}});
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (std::size_t c = 0; c < lit.offset(params.n_th, 0); ++c) lit.data()[c] = uniform(random);
  Twins twins(params);
  twins.fast.setActivity(lit);
  std::copy_n(twins.fast.activity().data(), twins.plain.cells().size(), twins.plain.cells().begin());
  twins.plain.decode();
  for (int step = 0; step < 5; ++step) {
    twins.step(0.8, -0.1);
    ASSERT_LT(twins.difference(), kPerStep);
    ASSERT_LT(twins.estimateDifference(), 1e-9);
    expectSound(twins.fast);
  }
}

INSTANTIATE_TEST_SUITE_P(Networks, AgainstOracle, testing::ValuesIn(cases()),
                         [](const auto& test) { return std::string(test.param.name); });

class Crossing : public testing::TestWithParam<double> {};

TEST_P(Crossing, EqualAcrossTheFacesInEveryDirection) {
  PoseCellParams params = sized(20, 24);
  for (const bool corner : {false, true}) {
    params.openratslam_corner = corner;
    Twins twins(params);
    twins.step(0.0, GetParam() - kPi);  // the packet starts at layer n_th / 2, which faces backwards
    for (int step = 0; step < 60; ++step) {
      twins.step(0.7, step < 30 ? 0.0 : 0.2);
      ASSERT_LT(twins.difference(), kPerStep) << "step " << step;
      ASSERT_LT(twins.estimateDifference(), 1e-9) << "step " << step;
    }
    expectSound(twins.fast);
  }
}

INSTANTIATE_TEST_SUITE_P(Headings, Crossing,
                         testing::Values(0.0, 0.7, kPi / 2, 2.4, kPi, -2.3, -kPi / 2, -0.9));

TEST(Packets, RivalsThatMeetMerge) {
  Twins twins(sized(40, 36));
  for (int step = 0; step < 20; ++step) twins.step(0.5, 0.0);
  twins.inject({6, 36, 21}, 0.9);  // its heading leads it into the way of the first
  std::vector<std::size_t> packets;
  for (int step = 0; step < 90; ++step) {
    twins.step(0.5, 0.0);
    ASSERT_LT(twins.difference(), kPerStep) << "step " << step;
    packets.push_back(twins.fast.activity().boxes().size());
  }
  EXPECT_EQ(packets.front(), 2U);
  EXPECT_EQ(packets.back(), 1U);
}

TEST(Packets, RivalsOnTheSeamsGoTheirOwnWays) {
  Twins twins(sized(40, 36));
  for (int step = 0; step < 20; ++step) twins.step(0.5, 0.0);
  twins.inject({0, 39, 35}, 0.9);
  for (int step = 0; step < 60; ++step) {
    twins.step(0.5, 0.07);
    ASSERT_LT(twins.difference(), kPerStep) << "step " << step;
    ASSERT_EQ(twins.fast.activity().boxes().size(), 2U) << "step " << step;
  }
}

TEST(Packets, AWideGapPartsABox) {
  PoseCellParams params = sized(40, 36);
  Twins twins(params);
  // A bar of activity that breaks up into packets.
  for (int column = 0; column < params.n_xy; ++column) twins.inject({column, 20, 18}, 0.02 * (column % 13));
  twins.step(0.3, 0.0);
  EXPECT_EQ(twins.fast.activity().boxes().size(), 1U);
  std::size_t most = 0;
  for (int step = 0; step < 40; ++step) {
    twins.step(0.3, 0.0);
    ASSERT_LT(twins.difference(), kPerStep) << "step " << step;
    expectSound(twins.fast);
    most = std::max(most, twins.fast.activity().boxes().size());
  }
  EXPECT_GE(most, 2U);
}

TEST(RealOdometry, EqualAfterTenThousandSteps) {
  const Table odometry = readTable(referenceFolder() + "/odometry.csv");
  if (odometry.empty()) GTEST_SKIP() << "no odometry.csv in " << referenceFolder();
  PoseCellParams params = referenceParams();
  params.n_xy = 21;
  Twins twins(params);
  for (int step = 0; step < 10000; ++step) {
    const std::size_t frame = 1 + static_cast<std::size_t>(step) % (odometry.size() - 1);
    const double dt =
        secondsBetween(stampFromSeconds(odometry[frame - 1][1]), stampFromSeconds(odometry[frame][1]));
    twins.step(odometry[frame][2] * dt, odometry[frame][3] * dt);
    ASSERT_LT(twins.estimateDifference(), 1e-9) << "step " << step;
  }
  EXPECT_LT(twins.difference(), 1e-9);
  EXPECT_EQ(twins.fast.reseeds(), 0U);
}

TEST(SimdLevels, GiveTheSameBits) {
  PoseCellParams params = sized(19, 21);
  params.excitation_dim = 9;  // neither of the kernels' unrolled sizes
  for (const PoseCellParams& tested : {params, sized(30, 36), sized(3, 5)}) {
    PoseCellNetwork portable(tested, SimdLevel::kScalar);
    std::vector<PoseCellNetwork> others;
    if (bestSimdLevel() >= SimdLevel::kAvx2) others.emplace_back(tested, SimdLevel::kAvx2);
    if (bestSimdLevel() >= SimdLevel::kAvx512) others.emplace_back(tested, SimdLevel::kAvx512);
    for (int step = 0; step < 60; ++step) {
      portable.step(0.37, 0.05 * (step % 7));
      portable.inject({step % tested.n_xy, 1 % tested.n_xy, step % tested.n_th}, 0.1);
      for (PoseCellNetwork& other : others) {
        other.step(0.37, 0.05 * (step % 7));
        other.inject({step % tested.n_xy, 1 % tested.n_xy, step % tested.n_th}, 0.1);
        const double* const cells = portable.activity().data();
        ASSERT_TRUE(
            std::equal(cells, cells + portable.activity().offset(tested.n_th, 0), other.activity().data()));
        ASSERT_EQ(other.estimate().x, portable.estimate().x);
        ASSERT_EQ(other.estimate().th, portable.estimate().th);
      }
    }
  }
}

}  // namespace
}  // namespace ratslam
