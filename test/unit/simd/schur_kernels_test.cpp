/// The elimination of points against its definition, and at every instruction set.
#include "ratslam/simd/schur_kernels.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstring>
#include <random>
#include <vector>

namespace ratslam {
namespace {

constexpr int kPoses = 4;

class SchurKernelsAt : public testing::TestWithParam<SimdLevel> {
 protected:
  SchurKernelsAt() {
    std::mt19937 random(1);
    const auto draw = [&] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
    for (const int pose : {0, 1, 3}) {  // pose 2 does not see the point
      views.push_back({pose, {}});
      for (auto& column : views.back().coupling) {
        for (int row = 0; row < 6; ++row) column[row] = draw();
      }
    }
    const Eigen::Matrix3d root = Eigen::Matrix3d::NullaryExpr(draw);
    inverse = root * root.transpose();
    gradient = Eigen::Vector3d::NullaryExpr(draw);
    Eigen::Map<Eigen::Matrix3d>(point.inverse[0]) = inverse;
    Eigen::Map<Eigen::Vector3d>(point.gradient) = gradient;
  }

  std::vector<PoseEquations> eliminated(SimdLevel level) const {
    std::vector<PoseEquations> equations(kPoses * kPoses);
    schurKernels(level).eliminatePoint(views.data(), static_cast<int>(views.size()), point, kPoses,
                                       equations.data());
    return equations;
  }

  std::vector<FreeView> views;
  Eigen::Matrix3d inverse;
  Eigen::Vector3d gradient;
  PointEquations point{};
};

TEST_P(SchurKernelsAt, TakesWhatAPointKnewToThePosesThatSawIt) {
  using Block = Eigen::Map<const Eigen::Matrix<double, kSchurRows, 6>>;
  using Coupling = Eigen::Map<const Eigen::Matrix<double, kSchurRows, 3>>;
  const std::vector<PoseEquations> equations = eliminated(GetParam());
  Eigen::Matrix<double, kSchurRows * kPoses, 6 * kPoses> hessian;
  hessian.setZero();
  Eigen::Matrix<double, kSchurRows, kPoses> right;
  right.setZero();
  for (const FreeView& a : views) {
    right.col(a.pose) -= Coupling(a.coupling[0]) * inverse * gradient;
    for (const FreeView& b : views) {
      if (b.pose > a.pose) continue;
      hessian.block<kSchurRows, 6>(kSchurRows * a.pose, 6 * b.pose) -=
          Coupling(a.coupling[0]) * inverse * Coupling(b.coupling[0]).transpose().leftCols<6>();
    }
  }
  for (int row = 0; row < kPoses; ++row) {
    for (int column = 0; column < kPoses; ++column) {
      const PoseEquations& block = equations[static_cast<std::size_t>(row * kPoses + column)];
      const auto expected = hessian.block<kSchurRows, 6>(kSchurRows * row, 6 * column);
      EXPECT_LT((Block(block.hessian[0]) - expected).norm(), 1e-12) << row << ' ' << column;
    }
    const Eigen::Map<const Eigen::Matrix<double, kSchurRows, 1>> found(
        equations[static_cast<std::size_t>(row * kPoses + row)].gradient);
    EXPECT_LT((found - right.col(row)).norm(), 1e-12) << row;
  }
}

TEST_P(SchurKernelsAt, GiveTheSameBitsAtEveryInstructionSet) {
  const std::vector<PoseEquations> here = eliminated(GetParam());
  const std::vector<PoseEquations> scalar = eliminated(SimdLevel::kScalar);
  EXPECT_EQ(std::memcmp(here.data(), scalar.data(), here.size() * sizeof here.front()), 0);
}

INSTANTIATE_TEST_SUITE_P(Levels, SchurKernelsAt, testing::ValuesIn(availableSimdLevels()));

}  // namespace
}  // namespace ratslam
