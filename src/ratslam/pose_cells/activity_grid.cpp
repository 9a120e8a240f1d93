#include "ratslam/pose_cells/activity_grid.h"

#include <cmath>

#include "ratslam/common/state.h"

namespace ratslam {

double wrapCoordinate(double value, int size) {
  const double rest = std::fmod(value, static_cast<double>(size));
  const double wrapped = rest < 0.0 ? rest + size : rest;
  return wrapped >= size ? 0.0 : wrapped;  // rounding can take a tiny negative rest to the full circle
}

ActivityGrid::ActivityGrid(int n_xy, int n_th)
    : sizes_{n_xy, n_xy, n_th}, cells_(index(n_xy) * index(n_xy) * index(n_th), 0.0) {}

double ActivityGrid::sum() const {
  double sum = 0.0;
  forEachRun([&](std::size_t first, std::size_t count) {
    for (std::size_t c = first; c < first + count; ++c) sum += cells_[c];
  });
  return sum;
}

void ActivityGrid::replaceBoxes(const std::vector<Box>& boxes) {
  boxes_.clear();
  cover(boxes);
}

bool ActivityGrid::isWhole(const Box& box) const {
  return box[kColumn].length == sizes_[kColumn] && box[kRow].length == sizes_[kRow] &&
         box[kLayer].length == sizes_[kLayer];
}

void ActivityGrid::zero(const Box& box) {
  const auto fill = [&](std::size_t first, std::size_t count) {
    std::fill_n(cells_.data() + first, count, 0.0);
  };
  forEachRun(box, fill);
}

void ActivityGrid::clear() {
  for (const Box& box : boxes_) zero(box);
  boxes_.clear();
}

void ActivityGrid::scale(double factor) {
  forEachRun([&](std::size_t first, std::size_t count) {
    for (std::size_t c = first; c < first + count; ++c) cells_[c] *= factor;
  });
}

void ActivityGrid::add(const PoseCell& cell, double activity) {
  cells_[offset(cell.layer, cell.row) + index(cell.column)] += activity;
  cover({Box{Span{cell.column, 1}, Span{cell.row, 1}, Span{cell.layer, 1}}});
}

void ActivityGrid::save(State& state) const {
  state.set("sizes", sizes_);
  std::vector<std::array<int, 6>> boxes;  // begin and length along columns, rows, layers
  for (const Box& box : boxes_) {
    std::array<int, 6> numbers{};
    for (const std::size_t axis : {kColumn, kRow, kLayer}) {
      numbers[2 * axis] = box[axis].begin;
      numbers[2 * axis + 1] = box[axis].length;
    }
    boxes.push_back(numbers);
  }
  state.set("boxes", boxes);
  std::vector<double> activity;
  forEachRun([&](std::size_t first, std::size_t count) {
    activity.insert(activity.end(), cells_.begin() + static_cast<std::ptrdiff_t>(first),
                    cells_.begin() + static_cast<std::ptrdiff_t>(first + count));
  });
  state.set("activity", activity);
}

void ActivityGrid::load(const State& state) {
  const auto refuse = [&state](const char* what) {
    throw std::runtime_error("state " + state.path() + ": " + what);
  };
  if (state.get<RingSizes>("sizes") != sizes_) refuse("pose cells of another size than the parameters say");
  std::vector<Box> boxes;
  std::size_t cells = 0;
  for (const auto& numbers : state.get<std::vector<std::array<int, 6>>>("boxes")) {
    Box box;
    std::size_t in_box = 1;
    for (const std::size_t axis : {kColumn, kRow, kLayer}) {
      box[axis] = {numbers[2 * axis], numbers[2 * axis + 1]};
      if (box[axis].begin < 0 || box[axis].begin >= sizes_[axis] || box[axis].length < 1 ||
          box[axis].length > sizes_[axis]) {
        refuse("a box of activity lies outside the pose cells");
      }
      in_box *= index(box[axis].length);
    }
    cells += in_box;
    boxes.push_back(box);
  }
  const auto activity = state.get<std::vector<double>>("activity");
  if (activity.size() != cells) refuse("the activity does not fill its boxes");
  clear();
  boxes_ = std::move(boxes);
  auto next = activity.begin();
  forEachRun([&](std::size_t first, std::size_t count) {
    std::copy_n(next, count, cells_.begin() + static_cast<std::ptrdiff_t>(first));
    next += static_cast<std::ptrdiff_t>(count);
  });
}

void ActivityGrid::cover(const std::vector<Box>& boxes) {
  for (Box box : boxes) {
    for (const std::size_t axis : {kColumn, kRow, kLayer})
      if (box[axis].length >= sizes_[axis]) box[axis] = {0, sizes_[axis]};
    mergeInto(boxes_, box, sizes_, 0);
  }
}

}  // namespace ratslam
