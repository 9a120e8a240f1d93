#include "ratslam/local_view/block_sad/block_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "test_data.h"

namespace ratslam {
namespace {

class Grids : public testing::TestWithParam<LocalViewParams> {
 protected:
  /// Sum of absolute differences at a shift, as docs/model.md has it.
  double difference(const std::vector<double>& view, const std::vector<double>& learned, int shift) const {
    const int columns = params_.view_template.x_size;
    const int begin = params_.panoramic ? 0 : params_.shift_match;
    double sum = 0.0;
    for (int y = 0; y < params_.view_template.y_size; ++y) {
      for (int x = 0; x < params_.comparedColumns(); ++x) {
        sum += std::abs(view[static_cast<std::size_t>(y * columns + begin + x)] -
                        learned[static_cast<std::size_t>(y * columns + (x + shift) % columns)]);
      }
    }
    return sum;
  }

  /// The same between blocks in 8 bits.
  double difference(const BlockGrid& grid, const std::vector<double>& view,
                    const std::vector<double>& learned, std::size_t shift_number) const {
    std::vector<std::vector<std::uint8_t>> views;
    grid.ofView(view, views);
    const std::vector<std::uint8_t>& of_view = views[std::min(shift_number, views.size() - 1)];
    const std::vector<std::uint8_t> of_template = grid.ofTemplate(learned);
    const BlockRun& run = grid.runs()[shift_number];
    double sum = 0.0;
    for (std::size_t i = 0; i < run.count; ++i) sum += std::abs(of_view[i] - of_template[run.begin + i]);
    return sum;
  }

  LocalViewParams params_ = GetParam();
  std::mt19937 random_{1};
};

TEST_P(Grids, OfValuesDifferAsTheValuesDo) {
  const BlockGrid grid = BlockGrid::ofValues(params_);
  for (int i = 0; i < 20; ++i) {
    const std::vector<double> view = randomValues(params_, random_);
    const std::vector<double> learned = randomValues(params_, random_);
    ASSERT_EQ(grid.runs().size(), static_cast<std::size_t>(params_.shiftCount()));
    for (int shift = 0; shift < params_.shiftCount(); ++shift) {
      const auto compared = static_cast<double>(grid.mostCompared());
      EXPECT_NEAR(difference(grid, view, learned, static_cast<std::size_t>(shift)),
                  255.0 * difference(view, learned, shift * params_.step_match), compared + 1e-6);
    }
  }
}

TEST_P(Grids, BoundTheDifferenceOfValuesFromBelow) {
  const BlockGrid grid = BlockGrid::coarse(params_);
  for (int i = 0; i < 20; ++i) {
    const std::vector<double> view = randomValues(params_, random_);
    std::vector<double> learned = randomValues(params_, random_);
    // A template brighter or darker than the view everywhere makes the bound tight.
    if (i % 2 == 0) {
      for (double& value : learned) value = 0.01 * value + (i % 4 == 0 ? 0.99 : 0.0);
    }
    for (int shift = 0; shift < params_.shiftCount(); ++shift) {
      const auto number = static_cast<std::size_t>(shift);
      const double of_values = 255.0 * difference(view, learned, shift * params_.step_match);
      const double of_blocks = difference(grid, view, learned, number);
      const auto blocks = static_cast<double>(grid.runs()[number].count);
      const auto in_block = static_cast<double>(grid.valuesInBlock());
      EXPECT_GT(blocks, 0.0);
      EXPECT_LE((of_blocks - blocks) * in_block, of_values + 1e-6);
      if (i % 2 == 0) {
        EXPECT_GE((of_blocks + blocks) * in_block, 0.6 * of_values);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Grids,
                         testing::Values(smallParams(60, 10, 5, 1, false), smallParams(60, 10, 5, 5, true),
                                         smallParams(37, 11, 0, 7, true), smallParams(33, 7, 3, 2, false),
                                         smallParams(13, 3, 2, 1, false), smallParams(21, 1, 10, 1, false),
                                         smallParams(1, 17, 0, 1, false), smallParams(1, 1, 25, 5, true),
                                         smallParams(60, 10, 25, 5, false)));

}  // namespace
}  // namespace ratslam
