/// Path integration of the pose cells: odometry moves the activity, eq. (2)'s last term.
///
///  1. Layer k is shifted by distance / pc_cell_x_size cells along its heading k * 2 pi / n_th. A shifted cell
///     distributes its activity over the four cells that it overlaps (bilinear). A distance of more than one
///     cell is divided into n equal sub-steps of at most one cell. They are done at once, as a shift whose
///     weights are the n-th power.
///  2. All layers are shifted by rotation * n_th / (2 pi) layers (linear interpolation).
///
/// The plane is a torus. With `pc_openratslam_corner` one cell of each layer is processed as in OpenRatSLAM, in
/// steps of at most one cell (OpenRatSLAM has no longer ones). This is the corner cell that the layer's motion
/// enters across both edges. It keeps its own share and the activity that arrives across both edges, but loses
/// the activity that arrives across one edge only. This was found by experiment: with it OpenRatSLAM's estimates
/// on a real drive are reproduced to 1e-12 cells, without it to no better than 0.9 cells once the packet has
/// passed the corner.
#pragma once

#include <array>
#include <vector>

#include "ratslam/pose_cells/activity_grid.h"
#include "ratslam/pose_cells/aligned_buffer.h"
#include "ratslam/pose_cells/params.h"
#include "ratslam/pose_cells/separable_filter.h"
#include "ratslam/simd/row_kernels.h"

namespace ratslam {

class PathIntegrator {
 public:
  PathIntegrator(const PoseCellParams& params, SimdLevel level);

  /// @throws std::invalid_argument naming a distance [m] or rotation [rad] that is not finite.
  void check(double distance, double rotation) const;

  /// Moves the activity and normalises it. @param distance [m]; @param rotation [rad]; @param sum of the grid's
  /// activity. @return the share of the activity that was not lost at corners; 0: the grid is empty.
  double integrate(ActivityGrid& grid, double distance, double rotation, double sum);

 private:
  /// Motion along one axis: the share weights[t] of the activity moves by t cells towards `sign`.
  struct Shift {
    int sign = 1;
    std::vector<double> weights;
  };
  /// One axis of the plane: the cells that a packet may reach.
  struct Extent {
    bool ring = false;
    int origin = 0;  ///< first reached cell of the network
    int count = 0;
    GatherAxis gather;
  };
  /// Motion of this step.
  struct Motion {
    double cells = 0.0;      ///< of one sub-step, negative backwards
    double sub_steps = 0.0;  ///< a whole number
    int reach = 0;           ///< largest motion of activity [cells]; N - 1 if it goes round the ring
    int whole_layers = 0;
    double part_layer = 0.0;  ///< in [0, 1)
  };
  /// A packet between the two steps: its layers are shifted, but not yet rotated.
  struct Packet {
    Box target{};  ///< cells that it reaches
    std::ptrdiff_t row_stride = 0;
    std::ptrdiff_t layer_stride = 0;
    AlignedBuffer<double> layers;  ///< the first is the neighbour that rotation mixes into the packet's first
  };

  Motion motionOf(double distance, double rotation) const;
  static void setShift(double cells, const Motion& motion, int size, Shift& shift);
  /// @param heading cosine or sine of the layers' headings, for this axis.
  void setExtent(const Box& box, std::size_t axis, const std::vector<double>& heading, const Motion& motion,
                 Extent& extent) const;
  /// Shifts a packet's layers; the grid is only read.
  void shiftLayers(const ActivityGrid& grid, const Box& box, const Motion& motion, Packet& packet);
  /// Shifts the gathered layer k. @param shifted receives the result.
  void shiftLayer(int k, const Motion& motion, std::ptrdiff_t row_stride, double* shifted);
  void loseAtCorner(int k, const Motion& motion, std::ptrdiff_t row_stride, double* shifted);
  /// Rotates a packet and writes or adds it to the grid. @param scale of the activity.
  void rotateInto(ActivityGrid& grid, const Packet& packet, const Motion& motion, double scale,
                  RowKernels::Blend blend);

  PoseCellParams params_;
  const RowKernels* kernels_;
  std::vector<double> cos_heading_, sin_heading_;  ///< of the layers
  double lost_ = 0.0;                              ///< activity lost at corners in this step
  Shift shift_x_, shift_y_;
  Extent columns_, rows_;
  std::vector<Packet> packets_;
  AlignedBuffer<double> gathered_;  ///< one layer's rows with the cells around them
  AlignedBuffer<double> along_y_;   ///< the same, shifted along y
  RowPlan moving_;
};

}  // namespace ratslam
