#include "ratslam/vision/essential_matrix.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <random>

namespace ratslam {
namespace {

constexpr std::size_t kSample = 5;

/// Essential matrices of five matches: Stewenius, Engels and Nister, "Recent developments on direct relative
/// orientation" (2006). E = x X + y Y + z Z + W is the null space of the epipolar constraints. det E = 0 and
/// 2 E E' E - tr(E E') E = 0 are ten cubics in (x, y, z). The eigenvectors of their action matrix are the solutions.
class FivePointSolver {
 public:
  FivePointSolver() {
    // The cubics' coefficients follow from their values at as many points as there are monomials.
    std::mt19937 generator;
    for (int k = 0; k < kMonomials; ++k) {
      for (int c = 0; c < 3; ++c) places_(c, k) = static_cast<double>(generator() % 2001) * 1e-3 - 1.0;
      values_.row(k) = monomials(places_.col(k)).transpose();
    }
    inverse_ = values_.inverse();
  }

  std::vector<Eigen::Matrix3d> solve(const std::array<const BearingPair*, kSample>& pairs) const {
    Eigen::Matrix<double, 9, 9> epipolar = Eigen::Matrix<double, 9, 9>::Zero();
    for (int k = 0; k < 5; ++k) {
      const BearingPair& pair = *pairs[static_cast<std::size_t>(k)];
      const Eigen::Vector3d first = pair.first.homogeneous();
      const Eigen::Vector3d second = pair.second.homogeneous();
      const Eigen::Matrix3d outer = second * first.transpose();
      epipolar.row(k) = Eigen::Map<const Eigen::Matrix<double, 1, 9>>(outer.data());
    }
    const Eigen::HouseholderQR<Eigen::Matrix<double, 9, 5>> qr(epipolar.topRows<5>().transpose());
    const Eigen::Matrix<double, 9, 9> q = qr.householderQ();
    std::array<Eigen::Matrix3d, 4> span;
    for (int k = 0; k < 4; ++k) {
      const Eigen::Matrix<double, 9, 1> column = q.col(5 + k);
      span[static_cast<std::size_t>(k)] = Eigen::Map<const Eigen::Matrix3d>(column.data());
    }
    const auto combine = [&span](const Eigen::Vector3d& at) -> Eigen::Matrix3d {
      return at.x() * span[0] + at.y() * span[1] + at.z() * span[2] + span[3];
    };

    Eigen::Matrix<double, kMonomials, 10> cubics;
    for (int k = 0; k < kMonomials; ++k) {
      const Eigen::Matrix3d e = combine(places_.col(k));
      const Eigen::Matrix3d square = e * e.transpose();
      const Eigen::Matrix3d trace = 2.0 * square * e - square.trace() * e;
      cubics.row(k).head<9>() = Eigen::Map<const Eigen::Matrix<double, 1, 9>>(trace.data());
      cubics(k, 9) = e.determinant();
    }
    const Eigen::Matrix<double, 10, kMonomials> coefficients = (inverse_ * cubics).transpose();
    const Matrix10 reduced = coefficients.leftCols<10>().partialPivLu().solve(coefficients.rightCols<10>());
    std::vector<Eigen::Matrix3d> solutions;
    if (!reduced.allFinite()) return solutions;

    // Multiplication of (xx, xy, yy, xz, yz, zz, x, y, z, 1) by x, with the cubic monomials replaced.
    Matrix10 action = Matrix10::Zero();
    constexpr std::array<int, 6> kCubicOf{0, 1, 2, 4, 5, 7};
    for (int k = 0; k < 6; ++k) action.row(k) = -reduced.row(kCubicOf[static_cast<std::size_t>(k)]);
    action(6, 0) = action(7, 1) = action(8, 3) = action(9, 6) = 1.0;
    const Eigen::EigenSolver<Matrix10> eigen(action);
    if (eigen.info() != Eigen::Success) return solutions;
    for (int k = 0; k < 10; ++k) {
      if (eigen.eigenvalues()[k].imag() != 0.0) continue;
      const Eigen::Matrix<double, 10, 1> v = eigen.eigenvectors().col(k).real();
      const Eigen::Matrix3d essential = combine(v.segment<3>(6) / v[9]);
      if (essential.allFinite()) solutions.push_back(essential / essential.norm());
    }
    return solutions;
  }

 private:
  static constexpr int kMonomials = 20;
  using Matrix10 = Eigen::Matrix<double, 10, 10>;

  static Eigen::Matrix<double, kMonomials, 1> monomials(const Eigen::Vector3d& at) {
    const double x = at.x();
    const double y = at.y();
    const double z = at.z();
    Eigen::Matrix<double, kMonomials, 1> m;
    m << x * x * x, x * x * y, x * y * y, y * y * y, x * x * z, x * y * z, y * y * z, x * z * z, y * z * z,
        z * z * z, x * x, x * y, y * y, x * z, y * z, z * z, x, y, z, 1.0;
    return m;
  }

  Eigen::Matrix<double, 3, kMonomials> places_;
  Eigen::Matrix<double, kMonomials, kMonomials> values_;
  Eigen::Matrix<double, kMonomials, kMonomials> inverse_;
};

/// Score by Sampson's approximation of the squared distance to the epipolar lines [sigma^2].
ConsensusScore scoreOf(const Eigen::Matrix3d& essential, const std::vector<BearingPair>& pairs) {
  ConsensusScore score{0.0, 0};
  for (const BearingPair& pair : pairs) {
    const Eigen::Vector3d line = essential * pair.first.homogeneous();
    const Eigen::Vector3d line_back = essential.transpose() * pair.second.homogeneous();
    const double off = pair.second.homogeneous().dot(line);
    // The pair's sigma contains the errors of both bearings: each has half of its square.
    const double slope = 0.5 * (line.head<2>().squaredNorm() + line_back.head<2>().squaredNorm());
    score.add(off * off / std::max(slope * pair.sigma * pair.sigma, 1e-300));
  }
  return score;
}

}  // namespace

std::optional<Eigen::Matrix3d> essentialConsensus(const std::vector<BearingPair>& pairs, int min_inliers,
                                                  const ConsensusParams& params) {
  if (pairs.size() < std::max(kSample + 1, static_cast<std::size_t>(min_inliers))) return std::nullopt;
  const FivePointSolver solver;
  Eigen::Matrix3d best = Eigen::Matrix3d::Zero();
  ConsensusScore best_score;
  drawSamples<kSample>(pairs.size(), params, [&](const std::array<std::size_t, kSample>& sample) {
    std::array<const BearingPair*, kSample> chosen{};
    std::transform(sample.begin(), sample.end(), chosen.begin(),
                   [&pairs](std::size_t i) { return &pairs[i]; });
    for (const Eigen::Matrix3d& essential : solver.solve(chosen)) {
      const ConsensusScore score = scoreOf(essential, pairs);
      if (score.cost < best_score.cost) {
        best = essential;
        best_score = score;
      }
    }
    return best_score.inliers;
  });
  if (best_score.inliers < std::max(min_inliers, static_cast<int>(kSample) + 1)) return std::nullopt;
  return best;
}

std::vector<RigidTransform> decomposeEssential(const Eigen::Matrix3d& essential) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Signs that make both bases right-handed only change the sign of E, which has no meaning.
  const Eigen::Matrix3d u = svd.matrixU() * svd.matrixU().determinant();
  const Eigen::Matrix3d v = svd.matrixV() * svd.matrixV().determinant();
  const Eigen::Matrix3d quarter = Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  std::vector<RigidTransform> motions;
  for (const Eigen::Matrix3d& turn : {quarter, Eigen::Matrix3d(quarter.transpose())}) {
    const Eigen::Quaterniond rotation = Eigen::Quaterniond(u * turn * v.transpose()).normalized();
    for (const double sign : {1.0, -1.0}) motions.push_back({rotation, sign * u.col(2)});
  }
  return motions;
}

}  // namespace ratslam
