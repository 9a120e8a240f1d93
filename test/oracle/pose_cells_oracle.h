/// Plain pose cells, straight from the model: double precision, the whole volume, the full three-dimensional
/// kernels (343 taps for excitation). It is what the fast network is tested against and measured against.
///
/// One odometry step: excitation, inhibition, global inhibition, normalisation, path integration, best
/// estimate. A cell without activity is skipped where it would only spread zeros, as any plain implementation
/// does.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

#include "ratslam/common/angles.h"
#include "ratslam/events.h"
#include "ratslam/pose_cells/params.h"

namespace ratslam::oracle {

inline int wrapIndex(int index, int size) { return ((index % size) + size) % size; }

inline double wrapCoordinate(double value, int size) {
  const double wrapped = value - size * std::floor(value / size);
  return wrapped >= size ? 0.0 : wrapped;
}

struct Estimate {
  double x = 0.0, y = 0.0, th = 0.0;
};

/// The attractor network on a torus of n_th x n_xy x n_xy cells.
class Network {
 public:
  explicit Network(const PoseCellParams& params)
      : params_(params),
        cells_(static_cast<std::size_t>(params.n_th) * params.n_xy * params.n_xy, 0.0),
        excitation_(kernel(params.excitation_dim, params.excitation_var, params.excitationVarTh())),
        inhibition_(kernel(params.inhibition_dim, params.inhibition_var, params.inhibitionVarTh())) {
    at(params.n_th / 2, params.n_xy / 2, params.n_xy / 2) = 1.0;
    estimate_ = {double(params.n_xy / 2), double(params.n_xy / 2), double(params.n_th / 2)};
  }

  void step(double distance, double rotation) {
    attract();
    integratePath(distance, rotation);
    decode();
  }

  void attract() {
    cells_ = convolve(cells_, excitation_, params_.excitation_dim);
    const std::vector<double> inhibited = convolve(cells_, inhibition_, params_.inhibition_dim);
    double sum = 0.0;
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      cells_[c] = std::max(0.0, cells_[c] - inhibited[c] - params_.global_inhibition);
      sum += cells_[c];
    }
    if (sum > 0.0) {
      for (double& cell : cells_) cell /= sum;
    } else {
      reseed();
    }
  }

  void integratePath(double distance, double rotation) {
    const double cells = distance / params_.cell_size;
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(cells))));
    for (int step = 0; step < steps; ++step)
      translate(cells / steps, params_.openratslam_corner && steps == 1);
    rotate(rotation * params_.n_th / (2.0 * kPi));
  }

  void decode() {
    const auto best = static_cast<int>(std::max_element(cells_.begin(), cells_.end()) - cells_.begin());
    const int n = params_.n_xy;
    estimate_.x = marginalMean(best % n, n, best, 0);
    estimate_.y = marginalMean(best / n % n, n, best, 1);
    estimate_.th = marginalMean(best / (n * n), params_.n_th, best, 2);
  }

  void inject(const Estimate& where, double energy) {
    const int n = params_.n_xy;
    at(static_cast<int>(where.th) % params_.n_th, static_cast<int>(where.y) % n,
       static_cast<int>(where.x) % n) += energy;
  }

  double& at(int k, int j, int i) {
    return cells_[(static_cast<std::size_t>(k) * params_.n_xy + j) * params_.n_xy + i];
  }
  double at(int k, int j, int i) const { return const_cast<Network*>(this)->at(k, j, i); }
  std::vector<double>& cells() { return cells_; }
  const std::vector<double>& cells() const { return cells_; }
  Estimate estimate() const { return estimate_; }
  std::uint64_t reseeds() const { return reseeds_; }

 private:
  static std::vector<double> kernel(int dim, double var, double var_th) {
    std::vector<double> weights;
    double sum = 0.0;
    const int r = dim / 2;
    for (int c = -r; c <= r; ++c)
      for (int b = -r; b <= r; ++b)
        for (int a = -r; a <= r; ++a) {
          weights.push_back(std::exp(-(a * a + b * b) / (2.0 * var * var) - c * c / (2.0 * var_th * var_th)));
          sum += weights.back();
        }
    for (double& weight : weights) weight /= sum;
    return weights;
  }

  std::vector<double> convolve(const std::vector<double>& in, const std::vector<double>& weights,
                               int dim) const {
    const int n = params_.n_xy;
    const int m = params_.n_th;
    const int r = dim / 2;
    std::vector<double> out(in.size(), 0.0);
    std::vector<int> wrapped(static_cast<std::size_t>(n) + 2 * r);
    for (int i = 0; i < n + 2 * r; ++i) wrapped[i] = wrapIndex(i - r, n);
    for (int k = 0; k < m; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const double activity = in[(static_cast<std::size_t>(k) * n + j) * n + i];
          if (activity == 0.0) continue;
          const double* weight = weights.data();
          for (int c = -r; c <= r; ++c) {
            double* layer = &out[static_cast<std::size_t>(wrapIndex(k + c, m)) * n * n];
            for (int b = 0; b < dim; ++b) {
              double* row = layer + static_cast<std::size_t>(wrapped[j + b]) * n;
              for (int a = 0; a < dim; ++a) row[wrapped[i + a]] += *weight++ * activity;
            }
          }
        }
    return out;
  }

  /// Shifts each layer by `cells` of at most one along its heading. With `lossy_corner`, what enters the
  /// corner cell that the direction of motion points at across exactly one edge is lost.
  void translate(double cells, bool lossy_corner) {
    const int n = params_.n_xy;
    std::vector<double> out(cells_.size(), 0.0);
    for (int k = 0; k < params_.n_th; ++k) {
      const double heading = k * 2.0 * kPi / params_.n_th;
      const double dx = cells * std::cos(heading);
      const double dy = cells * std::sin(heading);
      const int ix = static_cast<int>(std::floor(dx));
      const int iy = static_cast<int>(std::floor(dy));
      const double fx = dx - ix;
      const double fy = dy - iy;
      const int quadrant = (4 * k / params_.n_th + (cells < 0.0 ? 2 : 0)) % 4;
      const int corner_x = quadrant == 0 || quadrant == 3 ? 0 : n - 1;
      const int corner_y = quadrant < 2 ? 0 : n - 1;
      double* layer = &out[static_cast<std::size_t>(k) * n * n];
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const double activity = at(k, j, i);
          if (activity == 0.0) continue;
          for (int b = 0; b < 2; ++b)
            for (int a = 0; a < 2; ++a) {
              const int x = wrapIndex(i + ix + a, n);
              const int y = wrapIndex(j + iy + b, n);
              const bool over_x = x != i + ix + a;
              const bool over_y = y != j + iy + b;
              if (lossy_corner && x == corner_x && y == corner_y && over_x != over_y) continue;
              layer[y * n + x] += (a ? fx : 1.0 - fx) * (b ? fy : 1.0 - fy) * activity;
            }
        }
    }
    cells_ = out;
  }

  void rotate(double layers) {
    const int m = params_.n_th;
    const std::size_t plane = static_cast<std::size_t>(params_.n_xy) * params_.n_xy;
    const double whole = std::floor(layers);
    const double fraction = layers - whole;
    const int shift = wrapIndex(static_cast<int>(whole), m);
    std::vector<double> out(cells_.size(), 0.0);
    for (int k = 0; k < m; ++k) {
      const double* from = &cells_[k * plane];
      double* low = &out[wrapIndex(k + shift, m) * plane];
      double* high = &out[wrapIndex(k + shift + 1, m) * plane];
      for (std::size_t c = 0; c < plane; ++c) {
        low[c] += (1.0 - fraction) * from[c];
        high[c] += fraction * from[c];
      }
    }
    cells_ = out;
  }

  /// Circular mean along one axis of the activity within +-3 cells of the best cell; a ring shorter than the
  /// window is counted once.
  double marginalMean(int centre, int size, int best, int axis) const {
    const int n = params_.n_xy;
    const int length_xy = std::min(7, n);
    const int length_th = std::min(7, params_.n_th);
    double sine = 0.0;
    double cosine = 0.0;
    for (int c = 0; c < length_th; ++c)
      for (int b = 0; b < length_xy; ++b)
        for (int a = 0; a < length_xy; ++a) {
          const int i = wrapIndex(best % n - 3 + a, n);
          const int j = wrapIndex(best / n % n - 3 + b, n);
          const int k = wrapIndex(best / (n * n) - 3 + c, params_.n_th);
          const int along = axis == 0 ? i : axis == 1 ? j : k;
          sine += at(k, j, i) * std::sin(along * 2.0 * kPi / size);
          cosine += at(k, j, i) * std::cos(along * 2.0 * kPi / size);
        }
    if (sine == 0.0 && cosine == 0.0) return centre;
    return wrapCoordinate(std::atan2(sine, cosine) * size / (2.0 * kPi), size);
  }

  /// One unit of activity at the last best estimate, shared among the eight cells around it.
  void reseed() {
    ++reseeds_;
    std::fill(cells_.begin(), cells_.end(), 0.0);
    const int n = params_.n_xy;
    const int i = static_cast<int>(estimate_.x);
    const int j = static_cast<int>(estimate_.y);
    const int k = static_cast<int>(estimate_.th);
    const double fx = estimate_.x - i;
    const double fy = estimate_.y - j;
    const double fth = estimate_.th - k;
    for (int c = 0; c < 2; ++c)
      for (int b = 0; b < 2; ++b)
        for (int a = 0; a < 2; ++a)
          at((k + c) % params_.n_th, (j + b) % n, (i + a) % n) +=
              (c ? fth : 1.0 - fth) * (b ? fy : 1.0 - fy) * (a ? fx : 1.0 - fx);
  }

  PoseCellParams params_;
  std::vector<double> cells_;
  std::vector<double> excitation_;
  std::vector<double> inhibition_;
  Estimate estimate_;
  std::uint64_t reseeds_ = 0;
};

/// The whole module: network, view cell ties with saturation swept over all of them at each event, decisions
/// by search over all experiences.
class PoseCells {
 public:
  explicit PoseCells(const PoseCellParams& params) : params_(params), network(params) {}

  void integrate(double distance, double rotation) { network.step(distance, rotation); }

  void activate(const ViewEvent& event) {
    event_ = event;
    const double shift = event.relative_rad * params_.n_th / (2.0 * kPi);
    const auto known = views_.find(event.id);
    if (known == views_.end()) {
      const std::size_t known_before = views_.size();
      views_[event.id] = {network.estimate(), params_.active_decay, known_before};
    } else if (known->second.order + 10 < views_.size()) {
      View& view = known->second;
      if (event.id == previous_id_) view.decay += params_.active_decay;
      const double energy = params_.inject_energy * (30.0 - std::exp(1.2 * view.decay)) / 30.0;
      Estimate where = view.where;
      where.th = wrapCoordinate(where.th + shift, params_.n_th);
      if (energy > 0.0) network.inject(where, energy);
    }
    for (auto& [id, view] : views_) view.decay = std::max(params_.active_decay, view.decay - params_.restore);
    previous_id_ = event.id;
  }

  TopologicalAction decide() {
    TopologicalAction action;
    action.stamp = event_.stamp;
    action.src_id = action.dest_id = current_;
    const double none = std::numeric_limits<double>::infinity();
    const bool changed = experiences_.empty() || experiences_[current_].view != event_.id;
    if (!changed && distanceTo(current_) <= params_.experience_distance) {
      action.relative_rad = relativeTo(current_);
      return action;
    }
    double nearest = none;
    std::uint32_t match = 0;
    for (std::uint32_t e = 0; e < experiences_.size(); ++e) {
      if (experiences_[e].view != event_.id || e == current_) continue;
      if (distanceTo(e) < nearest) {
        nearest = distanceTo(e);
        match = e;
      }
    }
    if (nearest < params_.experience_distance) {
      action.kind = ActionKind::kCreateEdge;
    } else {
      action.kind = ActionKind::kCreateNode;
      match = static_cast<std::uint32_t>(experiences_.size());
      experiences_.push_back({network.estimate(), event_.id, event_.relative_rad});
    }
    action.dest_id = current_ = match;
    action.relative_rad = relativeTo(match);
    return action;
  }

 private:
  struct View {
    Estimate where;
    double decay = 0.0;
    std::size_t order = 0;
  };
  struct Experience {
    Estimate where;
    std::uint32_t view = 0;
    double relative_rad = 0.0;
  };

  double relativeTo(std::uint32_t id) const {
    return wrapAngle(event_.relative_rad - experiences_[id].relative_rad);
  }

  double distanceTo(std::uint32_t id) const {
    const Estimate& there = experiences_[id].where;
    const Estimate here = network.estimate();
    const double th = here.th - relativeTo(id) * params_.n_th / (2.0 * kPi);
    const double dx = std::abs(std::remainder(here.x - there.x, params_.n_xy));
    const double dy = std::abs(std::remainder(here.y - there.y, params_.n_xy));
    const double dth = std::abs(std::remainder(th - there.th, params_.n_th));
    return std::sqrt(dx * dx + dy * dy + dth * dth);
  }

  PoseCellParams params_;

 public:
  Network network;

 private:
  std::map<std::uint32_t, View> views_;
  std::vector<Experience> experiences_;
  ViewEvent event_;
  std::int64_t previous_id_ = -1;
  std::uint32_t current_ = 0;
};

}  // namespace ratslam::oracle
