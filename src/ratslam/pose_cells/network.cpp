#include "ratslam/pose_cells/network.h"

#include <cmath>

namespace ratslam {
namespace {

const PoseCellParams& validated(const PoseCellParams& params) {
  params.validate();
  return params;
}

}  // namespace

PoseCellNetwork::PoseCellNetwork(const PoseCellParams& params)
    : grid_(validated(params).n_xy, params.n_th),
      attractor_(params),
      path_integrator_(params),
      peak_decoder_(params.n_xy, params.n_th) {
  const int centre_xy = params.n_xy / 2;
  const int centre_th = params.n_th / 2;
  grid_.at({centre_xy, centre_xy, centre_th}) = 1.0;
  estimate_ = {static_cast<double>(centre_xy), static_cast<double>(centre_xy),
               static_cast<double>(centre_th)};
}

void PoseCellNetwork::step(double distance, double rotation) {
  path_integrator_.check(distance, rotation);
  attract();
  integratePath(distance, rotation);
  estimate_ = peak_decoder_.decode(grid_);
}

void PoseCellNetwork::attract() {
  if (!attractor_.iterate(grid_, model_sum_)) reseed();
  model_sum_ = 1.0;
}

void PoseCellNetwork::integratePath(double distance, double rotation) {
  path_integrator_.check(distance, rotation);
  const double kept = path_integrator_.integrate(grid_, distance, rotation);
  if (kept > 0.0) {
    model_sum_ *= kept;
  } else {
    reseed();
  }
}

void PoseCellNetwork::inject(const PoseCell& cell, double energy) {
  const double sum = model_sum_ + energy;
  grid_.scale(model_sum_ / sum);
  grid_.at(cell) += energy / sum;
  model_sum_ = sum;
}

/// Shared among the eight cells around the estimate, so that the packet starts where the robot was, not up to
/// half a cell beside it.
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
      for (const int a : {0, 1})
        grid_.at({wrapIndex(low.column + a, grid_.nXy()), wrapIndex(low.row + b, grid_.nXy()),
                  wrapIndex(low.layer + c, grid_.nTh())}) +=
            (a == 1 ? fx : 1.0 - fx) * (b == 1 ? fy : 1.0 - fy) * (c == 1 ? fth : 1.0 - fth);
}

}  // namespace ratslam
