#include "ratslam/pose_cells/activity_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ratslam {

double wrapCoordinate(double value, int size) {
  const double rest = std::fmod(value, static_cast<double>(size));
  const double wrapped = rest < 0.0 ? rest + size : rest;
  return wrapped >= size ? 0.0 : wrapped;  // a tiny negative rest rounds up to the full circle
}

void ActivityGrid::clear() { std::fill(cells_.begin(), cells_.end(), 0.0); }

void ActivityGrid::scale(double factor) {
  for (double& cell : cells_) cell *= factor;
}

double ActivityGrid::sum() const { return std::accumulate(cells_.begin(), cells_.end(), 0.0); }

std::vector<double> ActivityGrid::planeProjection() const {
  const std::size_t plane = static_cast<std::size_t>(n_xy_) * static_cast<std::size_t>(n_xy_);
  std::vector<double> projection(plane, 0.0);
  for (std::size_t c = 0; c < cells_.size(); ++c) projection[c % plane] += cells_[c];
  return projection;
}

std::vector<double> ActivityGrid::headingProjection() const {
  const std::size_t plane = static_cast<std::size_t>(n_xy_) * static_cast<std::size_t>(n_xy_);
  std::vector<double> projection(static_cast<std::size_t>(n_th_), 0.0);
  for (std::size_t c = 0; c < cells_.size(); ++c) projection[c / plane] += cells_[c];
  return projection;
}

}  // namespace ratslam
