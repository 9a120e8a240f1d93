#include "ratslam/pose_cells/network.h"

#include <cmath>

#include "ratslam/common/state.h"

namespace ratslam {
namespace {

const PoseCellParams& validated(const PoseCellParams& params) {
  params.validate();
  return params;
}

}  // namespace

PoseCellNetwork::PoseCellNetwork(const PoseCellParams& params, SimdLevel level)
    : grid_(validated(params).n_xy, params.n_th),
      attractor_(params, level),
      path_integrator_(params, level),
      peak_decoder_(params.n_xy, params.n_th, level) {
  const int centre_xy = params.n_xy / 2;
  const int centre_th = params.n_th / 2;
  grid_.add({centre_xy, centre_xy, centre_th}, 1.0);
  estimate_ = {static_cast<double>(centre_xy), static_cast<double>(centre_xy),
               static_cast<double>(centre_th)};
}

void PoseCellNetwork::step(double distance, double rotation) {
  path_integrator_.check(distance, rotation);
  const double sum = iterate();
  move(distance, rotation, sum);
  estimate_ = peak_decoder_.decode(grid_);
}

void PoseCellNetwork::attract() { grid_.scale(1.0 / iterate()); }

void PoseCellNetwork::integratePath(double distance, double rotation) {
  path_integrator_.check(distance, rotation);
  move(distance, rotation, 1.0);
}

/// One attractor iteration without normalisation. @return the sum of the activity.
double PoseCellNetwork::iterate() {
  const double sum = attractor_.iterate(grid_, model_sum_);
  model_sum_ = 1.0;
  if (sum > 0.0) return sum;
  reseed();
  return 1.0;
}

/// Moves and normalises the activity. @param sum of the activity before.
void PoseCellNetwork::move(double distance, double rotation, double sum) {
  const double kept = path_integrator_.integrate(grid_, distance, rotation, sum);
  if (kept > 0.0) {
    model_sum_ *= kept;
  } else {
    reseed();
  }
}

void PoseCellNetwork::inject(const PoseCell& cell, double energy) {
  injectAt({static_cast<double>(cell.column), static_cast<double>(cell.row), static_cast<double>(cell.layer)},
           energy);
}

void PoseCellNetwork::injectAt(const PoseCellEstimate& where, double energy) {
  const double sum = model_sum_ + energy;
  grid_.scale(model_sum_ / sum);
  const PoseCell first{static_cast<int>(where.x), static_cast<int>(where.y), static_cast<int>(where.th)};
  const double dx = where.x - first.column;
  const double dy = where.y - first.row;
  const double dth = where.th - first.layer;
  for (const int x : {0, 1}) {
    for (const int y : {0, 1}) {
      for (const int th : {0, 1}) {
        const double share =
            (x == 0 ? 1.0 - dx : dx) * (y == 0 ? 1.0 - dy : dy) * (th == 0 ? 1.0 - dth : dth);
        if (share == 0.0) continue;
        grid_.add({wrapIndex(first.column + x, grid_.nXy()), wrapIndex(first.row + y, grid_.nXy()),
                   wrapIndex(first.layer + th, grid_.nTh())},
                  share * energy / sum);
      }
    }
  }
  model_sum_ = sum;
}

void PoseCellNetwork::setActivity(const ActivityGrid& activity) {
  if (activity.sizes() != grid_.sizes())
    throw std::invalid_argument("activity: its shape is not the network's");
  activity.forEachRun([&](std::size_t first, std::size_t count) {
    for (std::size_t c = first; c < first + count; ++c)
      if (!(activity.data()[c] >= 0.0))
        throwBadValue("activity", activity.data()[c], "it must not be negative");
  });
  const double sum = activity.sum();
  if (!(std::isfinite(sum) && std::isfinite(1.0 / sum)))
    throwBadValue("activity", sum, "its sum must be positive and finite, and so must be its inverse");
  grid_ = activity;
  grid_.scale(1.0 / sum);
  model_sum_ = 1.0;
  estimate_ = peak_decoder_.decode(grid_);
}

void PoseCellNetwork::save(State& state) const {
  grid_.save(state.child("activity"));
  state.set("estimate", estimate_);
  state.set("reseeds", reseeds_);
  state.set("model_sum", model_sum_);
}

void PoseCellNetwork::load(const State& state) {
  grid_.load(state.child("activity"));
  state.get("estimate", estimate_);
  state.get("reseeds", reseeds_);
  state.get("model_sum", model_sum_);
}

/// Distributes the activity over the eight cells around the estimate. In one cell the packet would start up to
/// half a cell beside the estimate.
void PoseCellNetwork::reseed() {
  ++reseeds_;
  model_sum_ = 1.0;
  grid_.clear();
  const PoseCell low{static_cast<int>(estimate_.x), static_cast<int>(estimate_.y),
                     static_cast<int>(estimate_.th)};
  const double fx = estimate_.x - low.column;
  const double fy = estimate_.y - low.row;
  const double fth = estimate_.th - low.layer;
  for (const int c : {0, 1})
    for (const int b : {0, 1})
      for (const int a : {0, 1}) {
        const double share = (a == 1 ? fx : 1.0 - fx) * (b == 1 ? fy : 1.0 - fy) * (c == 1 ? fth : 1.0 - fth);
        grid_.add({wrapIndex(low.column + a, grid_.nXy()), wrapIndex(low.row + b, grid_.nXy()),
                   wrapIndex(low.layer + c, grid_.nTh())},
                  share);
      }
}

}  // namespace ratslam
