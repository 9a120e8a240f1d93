#include "ratslam/pose_cells/attractor.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

std::vector<double> gaussian(int dim, double width) {
  std::vector<double> weights;
  double sum = 0.0;
  for (int a = -(dim / 2); a <= dim / 2; ++a) {
    weights.push_back(std::exp(-a * a / (2.0 * width * width)));
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

}  // namespace

Attractor::Attractor(const PoseCellParams& params)
    : global_inhibition_(params.global_inhibition),
      excitation_xy_(gaussian(params.excitation_dim, params.excitation_var)),
      excitation_th_(gaussian(params.excitation_dim, params.excitationVarTh())),
      inhibition_xy_(gaussian(params.inhibition_dim, params.inhibition_var)),
      inhibition_th_(gaussian(params.inhibition_dim, params.inhibitionVarTh())) {}

ActivityGrid Attractor::convolve(const ActivityGrid& in, const std::vector<double>& xy,
                                 const std::vector<double>& th) const {
  const int n = in.nXy();
  const int m = in.nTh();
  const int r = static_cast<int>(xy.size()) / 2;
  ActivityGrid a(n, m), b(n, m), c(n, m);
  for (int k = 0; k < m; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        for (int t = -r; t <= r; ++t)
          a.at({i, j, k}) += xy[static_cast<std::size_t>(t + r)] * in.at({wrapIndex(i + t, n), j, k});
  for (int k = 0; k < m; ++k)
    for (int j = 0; j < n; ++j)
      for (int t = -r; t <= r; ++t)
        for (int i = 0; i < n; ++i)
          b.at({i, j, k}) += xy[static_cast<std::size_t>(t + r)] * a.at({i, wrapIndex(j + t, n), k});
  for (int k = 0; k < m; ++k)
    for (int t = -r; t <= r; ++t)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          c.at({i, j, k}) += th[static_cast<std::size_t>(t + r)] * b.at({i, j, wrapIndex(k + t, m)});
  return c;
}

bool Attractor::iterate(ActivityGrid& grid, double model_sum) {
  const ActivityGrid excited = convolve(grid, excitation_xy_, excitation_th_);
  const ActivityGrid inhibition = convolve(excited, inhibition_xy_, inhibition_th_);
  const double phi = global_inhibition_ / model_sum;
  double sum = 0.0;
  for (int k = 0; k < grid.nTh(); ++k)
    for (int j = 0; j < grid.nXy(); ++j)
      for (int i = 0; i < grid.nXy(); ++i) {
        const PoseCell cell{i, j, k};
        grid.at(cell) = std::max(0.0, excited.at(cell) - inhibition.at(cell) - phi);
        sum += grid.at(cell);
      }
  if (!(sum > 0.0)) return false;
  grid.scale(1.0 / sum);
  return true;
}

}  // namespace ratslam
