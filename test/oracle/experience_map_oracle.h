/// Plain implementations to hold the experience map against: the relaxation of docs/model.md as it is written there, and a
/// batch solution of SCALE_MAP's energy over all unknowns at once.
#pragma once

#include <Eigen/SparseCholesky>
#include <cmath>
#include <vector>

#include "ratslam/experience_map/experience_graph.h"
#include "ratslam/experience_map/solver/pose_graph.h"
#include "ratslam/simd/sine_cosine.h"

namespace ratslam {

/// Sine and cosine as the C library has them.
struct LibrarySineCosine {
  SineCosine operator()(double angle) const { return {std::sin(angle), std::cos(angle)}; }
};
/// Those of sine_cosine.h, within a unit in the last place of the library's, whose bits differ from one
/// version to the next. With them the plain sweeps and the map's can be compared to the last bit.
struct FixedSineCosine {
  SineCosine operator()(double angle) const { return sineCosine(angle); }
};

/// Equation (6) in the reference arithmetic: experiences by id, each with its outgoing links by age.
class OracleRelaxation {
 public:
  struct Node {
    double x = 0.0, y = 0.0, th = 0.0;
    std::vector<std::uint32_t> outgoing;
  };

  explicit OracleRelaxation(const ExperienceGraph& graph) : links_(graph.links()) {
    for (const Experience& experience : graph.experiences()) {
      nodes_.push_back({experience.pose.x, experience.pose.y, experience.pose.yaw, {}});
    }
    for (std::uint32_t k = 0; k < links_.size(); ++k) nodes_[links_[k].from].outgoing.push_back(k);
  }

  template <class OfAngle = FixedSineCosine>
  void sweep(int sweeps, double alpha, OfAngle of_angle = {}) {
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      for (Node& start : nodes_) {
        for (const std::uint32_t k : start.outgoing) {
          const Link& link = links_[k];
          Node& end = nodes_[link.to];
          const SineCosine direction = of_angle(start.th + link.heading_rad);
          const double lx = start.x + link.distance * direction.cosine;
          const double ly = start.y + link.distance * direction.sine;
          const double dx = alpha * (end.x - lx);
          const double dy = alpha * (end.y - ly);
          start.x += dx;
          start.y += dy;
          end.x -= dx;
          end.y -= dy;
          const double df = alpha * wrapAngle(end.th - (start.th + link.facing_rad));
          start.th += df;
          end.th -= df;
        }
      }
    }
  }

  /// The energy that the sweeps descend.
  double energy() const {
    double sum = 0.0;
    for (const Link& link : links_) {
      const Node& start = nodes_[link.from];
      const Node& end = nodes_[link.to];
      const double ex = end.x - start.x - link.distance * std::cos(start.th + link.heading_rad);
      const double ey = end.y - start.y - link.distance * std::sin(start.th + link.heading_rad);
      const double ef = wrapAngle(end.th - start.th - link.facing_rad);
      sum += ex * ex + ey * ey + ef * ef;
    }
    return sum;
  }

  const std::vector<Node>& nodes() const { return nodes_; }

 private:
  std::vector<Link> links_;
  std::vector<Node> nodes_;
};

/// Sweeps in the manner of equation (6) over the constraints of a weighted graph: what plain relaxation makes
/// of it.
inline void sweepPlainly(const PoseGraph& graph, std::vector<MapPose>& nodes, int sweeps, double alpha) {
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (const Constraint& constraint : graph.constraints()) {
      MapPose& start = nodes[constraint.from];
      MapPose& end = nodes[constraint.to];
      const MapPose expected = compose(start, constraint.measured);
      const double dx = alpha * (end.x - expected.x);
      const double dy = alpha * (end.y - expected.y);
      const double df = alpha * wrapAngle(end.yaw - expected.yaw);
      start.x += dx;
      start.y += dy;
      start.yaw += df;
      end.x -= dx;
      end.y -= dy;
      end.yaw -= df;
    }
  }
}

/// All nodes but the first, solved together by reweighted Gauss-Newton with a line search on SCALE_MAP's
/// energy as it is written there: residuals in the map's axes, derivatives by central differences.
/// @param scale, height which unknowns a node has beside x, y and facing. @param kernel of the recalls.
inline std::vector<MapPose> solveBatch(const PoseGraph& graph, std::vector<MapPose> nodes, bool scale,
                                       bool height, double kernel) {
  std::vector<int> components{0, 1, 2};
  if (scale) components.push_back(3);
  if (height) components.push_back(4);
  const auto size = static_cast<int>(components.size());
  using Vector5 = Eigen::Matrix<double, 5, 1>;

  const auto residual = [](const Constraint& c, const MapPose& i, const MapPose& j) {
    const double e = c.recall ? 1.0 : std::exp(i.log_scale);
    const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(i.yaw).toRotationMatrix();
    const Eigen::Vector2d place =
        Eigen::Vector2d(j.x - i.x, j.y - i.y) - e * (rotation * Eigen::Vector2d(c.measured.x, c.measured.y));
    Vector5 r;
    r.head<2>() = c.xy_weight * (rotation.transpose() * place);
    r[2] = c.yaw_weight * wrapAngle(j.yaw - i.yaw - c.measured.yaw);
    r[3] = c.recall ? 0.0 : c.scale_weight * (j.log_scale - i.log_scale);
    r[4] = c.z_weight * (j.z - i.z - e * c.measured.z);
    return r;
  };
  const auto energy = [&](const std::vector<MapPose>& at) {
    double sum = 0.0;
    for (const Constraint& c : graph.constraints()) {
      const double squared = residual(c, at[c.from], at[c.to]).squaredNorm();
      sum += c.recall ? kernel * kernel * std::log(1.0 + squared / (kernel * kernel)) : squared;
    }
    return sum;
  };
  const auto moved = [](MapPose pose, int component, double by) {
    double* const values[] = {&pose.x, &pose.y, &pose.yaw, &pose.log_scale, &pose.z};
    *values[component] += by;
    return pose;
  };

  const auto unknowns = static_cast<Eigen::Index>(nodes.size() - 1) * size;
  for (int iteration = 0; iteration < 200; ++iteration) {
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
    for (const Constraint& c : graph.constraints()) {
      const Vector5 r = residual(c, nodes[c.from], nodes[c.to]);
      const double weight = c.recall ? 1.0 / (1.0 + r.squaredNorm() / (kernel * kernel)) : 1.0;
      Eigen::Matrix<double, 5, Eigen::Dynamic> jacobian(5, 2 * size);
      constexpr double kStep = 1e-4;  // less, and the rounding of coordinates of kilometres would show
      for (int k = 0; k < size; ++k) {
        const int m = components[static_cast<std::size_t>(k)];
        jacobian.col(k) = (residual(c, moved(nodes[c.from], m, kStep), nodes[c.to]) -
                           residual(c, moved(nodes[c.from], m, -kStep), nodes[c.to])) /
                          (2.0 * kStep);
        jacobian.col(size + k) = (residual(c, nodes[c.from], moved(nodes[c.to], m, kStep)) -
                                  residual(c, nodes[c.from], moved(nodes[c.to], m, -kStep))) /
                                 (2.0 * kStep);
      }
      const Eigen::MatrixXd hessian = weight * jacobian.transpose() * jacobian;
      const Eigen::VectorXd gradient = weight * jacobian.transpose() * r;
      const auto indexOf = [&](int k) {
        const std::uint32_t node = k < size ? c.from : c.to;
        return node == 0 ? Eigen::Index{-1} : static_cast<Eigen::Index>(node - 1) * size + k % size;
      };
      for (int a = 0; a < 2 * size; ++a) {
        if (indexOf(a) < 0) continue;
        right[indexOf(a)] -= gradient[a];
        for (int b = 0; b < 2 * size; ++b) {
          if (indexOf(b) >= 0) {
            entries.emplace_back(static_cast<int>(indexOf(a)), static_cast<int>(indexOf(b)), hessian(a, b));
          }
        }
      }
    }
    Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
    const Eigen::VectorXd step = factor.solve(right);
    const double before = energy(nodes);
    bool fell = false;
    for (double share = 1.0; share > 1e-4 && !fell; share *= 0.5) {
      std::vector<MapPose> trial = nodes;
      for (std::size_t node = 1; node < nodes.size(); ++node) {
        for (int k = 0; k < size; ++k) {
          trial[node] = moved(trial[node], components[static_cast<std::size_t>(k)],
                              share * step[static_cast<Eigen::Index>(node - 1) * size + k]);
        }
      }
      fell = energy(trial) < before;
      if (fell) nodes = std::move(trial);
    }
    if (!fell || step.cwiseAbs().maxCoeff() < 1e-10) break;
  }
  return nodes;
}

}  // namespace ratslam
