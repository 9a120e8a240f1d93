#include "ratslam/experience_map/solver/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>
#include <random>

namespace ratslam {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// A chain with a few loops, one of them between neighbours.
std::vector<Edge> chainWithLoops(std::uint32_t unknowns) {
  std::vector<Edge> edges;
  for (std::uint32_t k = 0; k + 1 < unknowns; ++k) edges.emplace_back(k, k + 1);
  if (unknowns > 30) {
    for (const Edge& loop : {Edge{25, 3}, Edge{4, 26}, Edge{27, 10}, Edge{30, 0}, Edge{12, 13}})
      edges.push_back(loop);
  }
  return edges;
}

/// A random positive definite system on that pattern, in blocks and dense.
template <int Size>
struct System {
  System(std::uint32_t unknowns, unsigned seed)
      : structure(orderBlocks(unknowns, chainWithLoops(unknowns))),
        dense(Eigen::MatrixXd::Zero(unknowns * Size, unknowns * Size)),
        right(Eigen::VectorXd::Zero(unknowns * Size)) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    cholesky.reset(structure);
    const auto add = [&](std::uint32_t a, std::uint32_t b, const Eigen::Matrix<double, Size, Size>& block) {
      dense.block<Size, Size>(a * Size, b * Size) += block;
      if (a != b) dense.block<Size, Size>(b * Size, a * Size) += block.transpose();
      if (a == b) {
        cholesky.diagonal(structure.position[a]) += block;
      } else {
        cholesky.addBetween(structure.position[a], structure.position[b], block);
      }
    };
    for (const Edge& edge : chainWithLoops(unknowns)) {
      const auto block = [&] {
        return Eigen::Matrix<double, Size, Size>::NullaryExpr([&] { return uniform(random); });
      };
      const Eigen::Matrix<double, Size, Size> ja = block();
      const Eigen::Matrix<double, Size, Size> jb = block();
      add(edge.first, edge.first, ja.transpose() * ja);
      add(edge.second, edge.second, jb.transpose() * jb);
      add(edge.first, edge.second, ja.transpose() * jb);
    }
    for (std::uint32_t k = 0; k < unknowns; ++k) add(k, k, Eigen::Matrix<double, Size, Size>::Identity());
    for (Eigen::Index k = 0; k < right.size(); ++k) right[k] = uniform(random);
  }

  Eigen::VectorXd solve() const {
    std::vector<Eigen::Matrix<double, Size, 1>> x(structure.position.size());
    for (std::size_t k = 0; k < x.size(); ++k) {
      x[structure.position[k]] = right.segment<Size>(static_cast<Eigen::Index>(k) * Size);
    }
    cholesky.solve(x);
    Eigen::VectorXd solution(right.size());
    for (std::size_t k = 0; k < x.size(); ++k) {
      solution.segment<Size>(static_cast<Eigen::Index>(k) * Size) = x[structure.position[k]];
    }
    return solution;
  }

  BlockStructure structure;
  BlockCholesky<Size> cholesky;
  Eigen::MatrixXd dense;
  Eigen::VectorXd right;
};

template <class SizeConstant>
class BlockCholeskyOfSize : public testing::Test {};
using Sizes = testing::Types<std::integral_constant<int, 3>, std::integral_constant<int, 4>,
                             std::integral_constant<int, 5>>;
TYPED_TEST_SUITE(BlockCholeskyOfSize, Sizes);

TYPED_TEST(BlockCholeskyOfSize, SolvesAsTheDenseFactorisation) {
  for (const std::uint32_t unknowns : {1U, 2U, 7U, 40U}) {
    System<TypeParam::value> system(unknowns, unknowns);
    std::int64_t work = std::numeric_limits<std::int64_t>::max();
    ASSERT_TRUE(system.cholesky.factorise(work));
    EXPECT_TRUE(system.cholesky.definite());
    const Eigen::VectorXd expected = system.dense.ldlt().solve(system.right);
    EXPECT_LT((system.solve() - expected).norm(), 1e-9 * expected.norm()) << unknowns << " unknowns";
  }
}

TYPED_TEST(BlockCholeskyOfSize, SlicesChangeNothing) {
  System<TypeParam::value> whole(40, 9);
  System<TypeParam::value> sliced(40, 9);
  std::int64_t work = std::numeric_limits<std::int64_t>::max();
  whole.cholesky.factorise(work);
  int slices = 1;
  for (work = 5; !sliced.cholesky.factorise(work); work = 5) ++slices;
  EXPECT_GT(slices, 10);
  EXPECT_EQ(whole.solve(), sliced.solve());
}

TEST(BlockCholesky, ReportsAnIndefiniteSystem) {
  System<3> system(10, 1);
  system.cholesky.diagonal(6)(1, 1) = -1.0;
  std::int64_t work = std::numeric_limits<std::int64_t>::max();
  system.cholesky.factorise(work);
  EXPECT_FALSE(system.cholesky.definite());
}

TEST(BlockOrdering, AChainFillsInNothing) {
  std::vector<Edge> edges;
  for (std::uint32_t k = 0; k + 1 < 1000; ++k) edges.emplace_back(k, k + 1);
  EXPECT_EQ(orderBlocks(1000, edges).rows.size(), 999U);
}

TEST(BlockOrdering, FillGrowsWithTheLoopsNotWithTheChain) {
  const auto blocks = [](std::uint32_t unknowns) {
    std::vector<Edge> edges;
    for (std::uint32_t k = 0; k + 1 < unknowns; ++k) edges.emplace_back(k, k + 1);
    for (std::uint32_t k = 0; k < 10; ++k)
      edges.emplace_back(k * unknowns / 20, unknowns - 1 - k * unknowns / 25);
    return orderBlocks(unknowns, edges).rows.size();
  };
  EXPECT_LE(blocks(10000), 2U * 10000U + 200U);
}

}  // namespace
}  // namespace ratslam
