#include "ratslam/pose_cells/params.h"

#include <cstdint>

namespace ratslam {
namespace {

constexpr std::int64_t kMaxCells = std::int64_t{1} << 25;  // 2 GB: 55 bytes a cell with all scratch memory

void requireOdd(const char* key, int value) {
  if (value % 2 == 0) throwBadValue(key, value, "it must be odd, so that the kernel has a centre");
}

}  // namespace

void PoseCellParams::validate() const {
  checkBounds(*this);
  requireOdd("pc_w_e_dim", excitation_dim);
  requireOdd("pc_w_i_dim", inhibition_dim);
  if (std::int64_t{n_xy} * n_xy * n_th > kMaxCells)
    throwBadValue("pc_dim_xy", n_xy, "pc_dim_xy^2 * pc_dim_th must not exceed 2^25 cells, which take 2 GB");
}

}  // namespace ratslam
