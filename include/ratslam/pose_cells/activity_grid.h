/// Activity of the pose cells on a torus of heading layers, rows (y) and columns (x): P[k][j][i] of the
/// model.
///
/// Dense in memory, with a list of boxes outside which every cell is 0: whoever works on the activity goes
/// through the boxes, so that a packet of activity costs what its size costs, not the network's.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "ratslam/pose_cells/region.h"

namespace ratslam {

class State;

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

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("x", x);
    fields("y", y);
    fields("th", th);
  }
};

/// A coordinate on a ring of `size` cells, in [0, size).
double wrapCoordinate(double value, int size);

/// Non-negative activity of shape n_th x n_xy x n_xy.
class ActivityGrid {
 public:
  ActivityGrid(int n_xy, int n_th);

  int nXy() const { return sizes_[kColumn]; }
  int nTh() const { return sizes_[kLayer]; }
  const RingSizes& sizes() const { return sizes_; }
  double at(const PoseCell& cell) const { return cells_[offset(cell.layer, cell.row) + index(cell.column)]; }
  /// Disjoint boxes that hold all activity.
  const std::vector<Box>& boxes() const { return boxes_; }

  double sum() const;
  /// Activity summed over the headings, shape n_xy x n_xy, row by row.
  std::vector<double> planeProjection() const;
  /// Activity summed over the plane, shape n_th.
  std::vector<double> headingProjection() const;

  /// Multiplies all activity.
  void scale(double factor);
  void add(const PoseCell& cell, double activity);

  /// The cells, row by row, layer by layer. Whoever writes to them declares where by `cover`.
  const double* data() const { return cells_.data(); }
  double* data() { return cells_.data(); }
  /// Position of a row's first cell.
  std::size_t offset(int layer, int row) const {
    return (index(layer) * index(nXy()) + index(row)) * index(nXy());
  }
  /// Adds boxes to the list; those that overlap become one.
  void cover(const std::vector<Box>& boxes);
  /// A new list, of boxes that hold all activity.
  void replaceBoxes(const std::vector<Box>& boxes);
  /// Whether a box holds all cells.
  bool isWhole(const Box& box) const;
  /// Sets the cells of a box to 0; the list stays as it is.
  void zero(const Box& box);
  /// Sets all cells to 0 and empties the list.
  void clear();

  /// The boxes and the activity in them, in the order of forEachRun.
  void save(State& state) const;
  /// @throws std::runtime_error where the state is of a grid of another shape
  void load(const State& state);

  /// Calls `visit(first, count)` for each unbroken stretch of cells of the boxes, `first` being its position.
  template <class Visitor>
  void forEachRun(Visitor visit) const {
    for (const Box& box : boxes_) forEachRun(box, visit);
  }

 private:
  template <class Visitor>
  void forEachRun(const Box& box, Visitor& visit) const;
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  RingSizes sizes_;
  std::vector<double> cells_;
  std::vector<Box> boxes_;
};

template <class Visitor>
void ActivityGrid::forEachRun(const Box& box, Visitor& visit) const {
  const int n = nXy();
  const bool whole_rows = box[kColumn].length == n;
  const bool whole_layers = whole_rows && box[kRow].length == n;
  for (int c = 0; c < box[kLayer].length; ++c) {
    const int layer = wrapIndex(box[kLayer].begin + c, nTh());
    if (whole_layers) {
      visit(offset(layer, 0), offset(1, 0));
      continue;
    }
    for (int b = 0; b < box[kRow].length; ++b) {
      const std::size_t row = offset(layer, wrapIndex(box[kRow].begin + b, n));
      const int before_end = std::min(box[kColumn].length, n - box[kColumn].begin);
      visit(row + index(box[kColumn].begin), index(before_end));
      if (before_end < box[kColumn].length) visit(row, index(box[kColumn].length - before_end));
    }
  }
}

}  // namespace ratslam
