#include "ratslam/vision/recall_consensus.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <random>

namespace ratslam {
namespace {

constexpr double kGate = 4.0;         // largest error of an inlier [sigma]
constexpr double kConfidence = 0.99;  // probability that one sample was free of outliers
constexpr int kMinSamples = 50;  // the first clean sample may lead to the wrong one of two similar minima
constexpr int kEpipolarSamples = 150;
constexpr int kResectionSamples = 300;

struct Score {
  double cost = std::numeric_limits<double>::infinity();
  int inliers = 0;
};

void addTo(Score& score, double squared_error) {
  score.cost += std::min(squared_error, kGate * kGate);
  if (squared_error < kGate * kGate) ++score.inliers;
}

/// Score by Sampson's approximation of the squared distance to the epipolar lines [sigma^2].
Score epipolarScore(const Eigen::Matrix3d& essential, const std::vector<RecallPair>& pairs) {
  Score score{0.0, 0};
  for (const RecallPair& pair : pairs) {
    const Eigen::Vector3d line = essential * pair.anchor.homogeneous();
    const Eigen::Vector3d line_back = essential.transpose() * pair.bearing.homogeneous();
    const double off = pair.bearing.homogeneous().dot(line);
    // The pair's sigma contains the errors of both bearings: each has half of its square.
    const double slope = 0.5 * (line.head<2>().squaredNorm() + line_back.head<2>().squaredNorm());
    addTo(score, off * off / std::max(slope * pair.sigma * pair.sigma, 1e-300));
  }
  return score;
}

Score poseScore(const RecallView& view, const std::vector<RecallPair>& pairs) {
  Score score{0.0, 0};
  for (const RecallPair& pair : pairs) {
    const double error = recallError(
        view, pair, pair.inverse_depth ? *pair.inverse_depth : inverseDepth(view, pair.anchor, pair.bearing));
    addTo(score, error * error);
  }
  return score;
}

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

  std::vector<Eigen::Matrix3d> solve(const std::array<const RecallPair*, 5>& pairs) const {
    Eigen::Matrix<double, 9, 9> epipolar = Eigen::Matrix<double, 9, 9>::Zero();
    for (int k = 0; k < 5; ++k) {
      const RecallPair& pair = *pairs[static_cast<std::size_t>(k)];
      const Eigen::Vector3d anchor = pair.anchor.homogeneous();
      const Eigen::Vector3d bearing = pair.bearing.homogeneous();
      const Eigen::Matrix3d outer = bearing * anchor.transpose();
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

/// Draws samples of `kSize` pairs until one of them is free of outliers with probability `kConfidence`.
/// @param consider called with the indices of a sample; returns the inliers of the best model so far
template <std::size_t kSize, class Consider>
void drawSamples(std::size_t count, int most, Consider&& consider) {
  std::mt19937 generator;  // the C++ standard defines its sequence
  int needed = most;
  for (int drawn = 0; drawn < needed; ++drawn) {
    std::array<std::size_t, kSize> sample;
    for (std::size_t k = 0; k < kSize;) {
      sample[k] = generator() % count;
      if (std::find(sample.begin(), sample.begin() + static_cast<std::ptrdiff_t>(k), sample[k]) ==
          sample.begin() + static_cast<std::ptrdiff_t>(k)) {
        ++k;
      }
    }
    const double share = static_cast<double>(consider(sample)) / static_cast<double>(count);
    const double clean = std::pow(share, static_cast<double>(kSize));
    // log1p(-1) is minus infinity, which gives the least number; log1p(0) is 0, which gives the most.
    const double enough = std::log(1.0 - kConfidence) / std::log1p(-clean);
    needed = static_cast<int>(std::clamp(std::abs(enough), 1.0 * kMinSamples, 1.0 * most));
  }
}

/// Of the four motions of an essential matrix, the one with most points in front of both views.
RecallView motionOf(const Eigen::Matrix3d& essential, const std::vector<RecallPair>& pairs) {
  cv::Mat matrix;
  cv::eigen2cv(essential, matrix);
  cv::Mat turns[2];
  cv::Mat direction;
  cv::decomposeEssentialMat(matrix, turns[0], turns[1], direction);
  RecallView best;
  Score best_score;
  for (const cv::Mat& turn : turns) {
    for (const double sign : {1.0, -1.0}) {
      RecallView view;
      view.motion = RecallMotion::kUnit;
      cv::cv2eigen(turn, view.R);
      cv::cv2eigen(direction, view.t);
      view.t *= sign;
      const Score score = poseScore(view, pairs);
      if (score.cost < best_score.cost) {
        best = view;
        best_score = score;
      }
    }
  }
  return best;
}

}  // namespace

double recallError(const RecallView& view, const RecallPair& pair, double inverse_depth) {
  const Eigen::Vector3d m = view.R * pair.anchor.homogeneous() + inverse_depth * view.t;
  if (!(m.z() > 0.0)) return std::numeric_limits<double>::infinity();
  return (m.hnormalized() - pair.bearing).norm() / pair.sigma;
}

std::optional<RecallView> epipolarConsensus(const std::vector<RecallPair>& pairs, int min_inliers) {
  constexpr std::size_t kSize = 5;
  if (pairs.size() < std::max<std::size_t>(kSize + 1, static_cast<std::size_t>(min_inliers)))
    return std::nullopt;
  const FivePointSolver solver;
  Eigen::Matrix3d best = Eigen::Matrix3d::Zero();
  Score best_score;
  drawSamples<kSize>(pairs.size(), kEpipolarSamples, [&](const std::array<std::size_t, kSize>& sample) {
    std::array<const RecallPair*, kSize> chosen{};
    std::transform(sample.begin(), sample.end(), chosen.begin(),
                   [&pairs](std::size_t i) { return &pairs[i]; });
    for (const Eigen::Matrix3d& essential : solver.solve(chosen)) {
      const Score score = epipolarScore(essential, pairs);
      if (score.cost < best_score.cost) {
        best = essential;
        best_score = score;
      }
    }
    return best_score.inliers;
  });
  if (best_score.inliers < min_inliers) return std::nullopt;
  return motionOf(best, pairs);
}

std::optional<RecallView> resectionConsensus(const std::vector<RecallPair>& pairs, int min_inliers) {
  constexpr std::size_t kSize = 3;
  std::vector<RecallPair> known;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(known),
               [](const RecallPair& pair) { return pair.inverse_depth && *pair.inverse_depth > 0.0; });
  if (known.size() < std::max<std::size_t>(kSize + 1, static_cast<std::size_t>(min_inliers)))
    return std::nullopt;
  RecallView best;
  Score best_score;
  drawSamples<kSize>(known.size(), kResectionSamples, [&](const std::array<std::size_t, kSize>& sample) {
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> bearings;
    for (const std::size_t i : sample) {
      const RecallPair& pair = known[i];
      points.emplace_back(pair.anchor.x() / *pair.inverse_depth, pair.anchor.y() / *pair.inverse_depth,
                          1.0 / *pair.inverse_depth);
      bearings.emplace_back(pair.bearing.x(), pair.bearing.y());
    }
    std::vector<cv::Mat> turns;
    std::vector<cv::Mat> translations;
    cv::solveP3P(points, bearings, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turns, translations,
                 cv::SOLVEPNP_AP3P);
    for (std::size_t s = 0; s < turns.size(); ++s) {
      Eigen::Vector3d turn;
      RecallView view;
      cv::cv2eigen(turns[s], turn);
      cv::cv2eigen(translations[s], view.t);
      if (!turn.allFinite() || !view.t.allFinite()) continue;
      view.R = Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()).toRotationMatrix();
      const Score score = poseScore(view, known);
      if (score.cost < best_score.cost) {
        best = view;
        best_score = score;
      }
    }
    return best_score.inliers;
  });
  if (best_score.inliers < min_inliers) return std::nullopt;
  return best;
}

}  // namespace ratslam
