/// Activity of the pose cells on a torus of heading layers, rows (y) and columns (x): P[k][j][i] of the
/// model.
///
/// The array is dense. A list of boxes says where activity is: every cell outside them is 0. All work on the
/// activity goes through the boxes. So its cost depends on the size of the packet and not of the network.
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

/// A position in the network in continuous cell coordinates.
struct PoseCellEstimate {
  double x = 0.0;   ///< [0, n_xy)
  double y = 0.0;   ///< [0, n_xy)
  double th = 0.0;  ///< [0, n_th); layer k has the heading k * 2 pi / n_th

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("x", x);
    fields("y", y);
    fields("th", th);
  }
};

/// Wraps a coordinate on a ring of `size` cells to [0, size).
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

  /// Multiplies all activity.
  void scale(double factor);
  void add(const PoseCell& cell, double activity);

  /// The cells, row by row, layer by layer. After writing to them, declare the boxes by cover().
  const double* data() const { return cells_.data(); }
  double* data() { return cells_.data(); }
  /// Index of a row's first cell in data().
  std::size_t offset(int layer, int row) const {
    return (index(layer) * index(nXy()) + index(row)) * index(nXy());
  }
  /// Adds boxes to the list and merges those that overlap.
  void cover(const std::vector<Box>& boxes);
  /// Replaces the list. The boxes must hold all activity.
  void replaceBoxes(const std::vector<Box>& boxes);
  /// Whether a box holds all cells.
  bool isWhole(const Box& box) const;
  /// Sets the cells of a box to 0. The list does not change.
  void zero(const Box& box);
  /// Sets all cells to 0 and empties the list.
  void clear();

  /// Saves the boxes and the activity in them, in the order of forEachRun.
  void save(State& state) const;
  /// @throws std::runtime_error if the state is of a grid of another shape
  void load(const State& state);

  /// Calls `visit(first, count)` for each run of contiguous cells of the boxes. `first` is an index in data().
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
