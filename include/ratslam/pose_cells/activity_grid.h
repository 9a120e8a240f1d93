/// Activity of the pose cells on a torus of heading layers, rows (y) and columns (x): P[k][j][i] of the
/// model.
#pragma once

#include <cstddef>
#include <vector>

namespace ratslam {

/// A cell of the torus.
struct PoseCell {
  int column = 0;  ///< along x, [0, n_xy)
  int row = 0;     ///< along y, [0, n_xy)
  int layer = 0;   ///< heading, [0, n_th)
};

/// A place in the network in continuous cell coordinates.
struct PoseCellEstimate {
  double x = 0.0;   ///< [0, n_xy)
  double y = 0.0;   ///< [0, n_xy)
  double th = 0.0;  ///< [0, n_th), layer k faces k * 2 pi / n_th
};

/// `index` on a ring of `size` cells, in [0, size).
inline int wrapIndex(int index, int size) {
  const int rest = index % size;
  return rest < 0 ? rest + size : rest;
}

/// A coordinate on a ring of `size` cells, in [0, size).
double wrapCoordinate(double value, int size);

/// Non-negative activity of shape n_th x n_xy x n_xy, dense in memory.
class ActivityGrid {
 public:
  ActivityGrid(int n_xy, int n_th)
      : n_xy_(n_xy),
        n_th_(n_th),
        cells_(
            static_cast<std::size_t>(n_xy) * static_cast<std::size_t>(n_xy) * static_cast<std::size_t>(n_th),
            0.0) {}

  int nXy() const { return n_xy_; }
  int nTh() const { return n_th_; }
  const double* row(int layer, int row) const { return cells_.data() + offset(layer, row); }
  double* row(int layer, int row) { return cells_.data() + offset(layer, row); }
  double at(const PoseCell& cell) const { return row(cell.layer, cell.row)[cell.column]; }
  double& at(const PoseCell& cell) { return row(cell.layer, cell.row)[cell.column]; }

  void clear();
  /// Multiplies all activity.
  void scale(double factor);
  double sum() const;
  /// Activity summed over the headings, shape n_xy x n_xy, row by row.
  std::vector<double> planeProjection() const;
  /// Activity summed over the plane, shape n_th.
  std::vector<double> headingProjection() const;

 private:
  std::size_t offset(int layer, int row) const {
    return (static_cast<std::size_t>(layer) * static_cast<std::size_t>(n_xy_) +
            static_cast<std::size_t>(row)) *
           static_cast<std::size_t>(n_xy_);
  }

  int n_xy_;
  int n_th_;
  std::vector<double> cells_;
};

}  // namespace ratslam
