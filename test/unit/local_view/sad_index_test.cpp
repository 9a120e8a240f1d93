#include "ratslam/local_view/block_sad/sad_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "test_data.h"

namespace ratslam {
namespace {

constexpr std::size_t kTemplates = 21;  // the last group is partly empty

class SadIndices : public testing::TestWithParam<LocalViewParams> {
 protected:
  /// The smallest over all shifts, block by block.
  static std::uint32_t smallestSad(const BlockGrid& grid, const std::vector<double>& view,
                                   const std::vector<double>& learned) {
    std::vector<std::vector<std::uint8_t>> views;
    grid.ofView(view, views);
    const std::vector<std::uint8_t> of_template = grid.ofTemplate(learned);
    std::uint32_t smallest = UINT32_MAX;
    for (std::size_t shift = 0; shift < grid.runs().size(); ++shift) {
      const BlockRun& run = grid.runs()[shift];
      const std::vector<std::uint8_t>& of_view = views[std::min(shift, views.size() - 1)];
      std::uint32_t sum = 0;
      for (std::size_t i = 0; i < run.count; ++i) {
        sum += static_cast<std::uint32_t>(std::abs(of_view[i] - of_template[run.begin + i]));
      }
      smallest = std::min(smallest, sum);
    }
    return smallest;
  }

  void expectSmallestSads(const BlockGrid& grid) {
    std::vector<std::vector<double>> learned;
    for (std::size_t id = 0; id < kTemplates; ++id) learned.push_back(randomValues(params_, random_));
    const std::vector<double> black(learned[0].size(), 0.0);
    const std::vector<double> white(learned[0].size(), 1.0);
    learned[7] = black;
    learned[8] = white;
    for (const SimdLevel level : availableSimdLevels()) {
      SadIndex index(grid, level);
      for (const std::vector<double>& values : learned) index.add(values);
      std::vector<std::uint32_t> sads(index.groupCount() * 8);
      for (const std::vector<double>& view : {randomValues(params_, random_), black, white}) {
        index.setView(view);
        index.smallestSads(0, index.groupCount(), sads.data());
        for (std::size_t id = 0; id < kTemplates; ++id) {
          ASSERT_EQ(sads[id], smallestSad(grid, view, learned[id])) << "template " << id;
        }
      }
    }
  }

  LocalViewParams params_ = GetParam();
  std::mt19937 random_{1};
};

TEST_P(SadIndices, OfValuesGiveTheSmallestSads) { expectSmallestSads(BlockGrid::ofValues(params_)); }
TEST_P(SadIndices, OfBlocksGiveTheSmallestSads) { expectSmallestSads(BlockGrid::coarse(params_)); }

// Columns and shifts of every remainder by 4 and 8: the end of a row then lies at every place of a chunk.
INSTANTIATE_TEST_SUITE_P(Shapes, SadIndices,
                         testing::Values(smallParams(60, 10, 5, 1, false), smallParams(61, 10, 5, 1, false),
                                         smallParams(62, 9, 5, 1, false), smallParams(63, 7, 4, 1, false),
                                         smallParams(64, 10, 6, 1, false), smallParams(65, 3, 3, 1, false),
                                         smallParams(57, 5, 10, 1, false), smallParams(66, 1, 13, 1, false),
                                         smallParams(300, 40, 6, 1, false), smallParams(37, 11, 0, 7, true),
                                         smallParams(33, 7, 3, 2, false), smallParams(60, 10, 25, 5, false)));

}  // namespace
}  // namespace ratslam
