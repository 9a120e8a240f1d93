#include "ratslam/pose_cells/path_integration.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"

namespace ratslam {

PathIntegrator::PathIntegrator(const PoseCellParams& params) : params_(params) {}

void PathIntegrator::check(double distance, double rotation) const {
  if (!std::isfinite(distance / params_.cell_size)) throwBadValue("distance", distance, "it must be finite");
  if (!std::isfinite(rotation)) throwBadValue("rotation", rotation, "it must be finite");
}

double PathIntegrator::integrate(ActivityGrid& grid, double distance, double rotation) {
  const double cells = distance / params_.cell_size;
  const int n = grid.nXy();
  const int m = grid.nTh();
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(cells))));
  const double d = cells / steps;
  for (int s = 0; s < steps; ++s) {
    ActivityGrid out(n, m);
    for (int k = 0; k < m; ++k) {
      const double heading = k * 2.0 * kPi / m;
      const double dx = d * std::cos(heading);
      const double dy = d * std::sin(heading);
      const int ix = static_cast<int>(std::floor(dx));
      const int iy = static_cast<int>(std::floor(dy));
      const double fx = dx - ix;
      const double fy = dy - iy;
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const double activity = grid.at({i, j, k});
          for (const int b : {0, 1})
            for (const int a : {0, 1})
              out.at({wrapIndex(i + ix + a, n), wrapIndex(j + iy + b, n), k}) +=
                  (a == 1 ? fx : 1.0 - fx) * (b == 1 ? fy : 1.0 - fy) * activity;
        }
      if (params_.openratslam_corner && steps == 1) {
        const int quadrant = (4 * k / m + (d < 0.0 ? 2 : 0)) % 4;
        const int sx = quadrant == 0 || quadrant == 3 ? 1 : -1;
        const int sy = quadrant < 2 ? 1 : -1;
        const PoseCell corner{sx > 0 ? 0 : n - 1, sy > 0 ? 0 : n - 1, k};
        const double ax = std::abs(dx);
        const double ay = std::abs(dy);
        out.at(corner) =
            (1.0 - ax) * (1.0 - ay) * grid.at(corner) +
            ax * ay * grid.at({wrapIndex(corner.column - sx, n), wrapIndex(corner.row - sy, n), k});
      }
    }
    grid = out;
  }
  const double layers = wrapCoordinate(wrapAngle(rotation) * m / (2.0 * kPi), m);
  const int whole = static_cast<int>(layers);
  const double fraction = layers - whole;
  ActivityGrid out(n, m);
  for (int k = 0; k < m; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        out.at({i, j, wrapIndex(k + whole, m)}) += (1.0 - fraction) * grid.at({i, j, k});
        out.at({i, j, wrapIndex(k + whole + 1, m)}) += fraction * grid.at({i, j, k});
      }
  grid = out;
  const double sum = grid.sum();
  if (sum > 0.0) grid.scale(1.0 / sum);
  return sum;
}

}  // namespace ratslam
