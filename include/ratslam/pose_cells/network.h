/// The continuous attractor network of the pose cells, eqs. (1) and (2). Source: docs/theory.md#pose-cells.
///
/// Steps: local excitation, local inhibition, global inhibition, normalisation (attractor.h), path integration
/// (path_integration.h), best estimate (peak.h). Between two steps views inject activity.
#pragma once

#include <cstdint>

#include "ratslam/pose_cells/activity_grid.h"
#include "ratslam/pose_cells/attractor.h"
#include "ratslam/pose_cells/params.h"
#include "ratslam/pose_cells/path_integration.h"
#include "ratslam/pose_cells/peak.h"
#include "ratslam/simd/row_kernels.h"

namespace ratslam {

/// Non-negative activity of shape n_th x n_xy x n_xy. It sums to 1 after every call. At the start it is 1 in the
/// centre cell.
class PoseCellNetwork {
 public:
  /// @param level instruction set to use; results do not depend on it.
  /// @throws std::invalid_argument as PoseCellParams::validate.
  explicit PoseCellNetwork(const PoseCellParams& params, SimdLevel level = bestSimdLevel());

  /// One odometry step: attract, integratePath, and a new estimate.
  /// @param distance [m] along the heading, negative backwards; @param rotation [rad], CCW positive
  /// (REP-103).
  /// @throws std::invalid_argument if either is not finite. The network is then unchanged.
  void step(double distance, double rotation);

  /// One iteration of the attractor. If all activity dies, it starts again at the last estimate.
  void attract();
  /// Moves the packet. Does not change the estimate. @throws std::invalid_argument as step.
  void integratePath(double distance, double rotation);
  /// Adds activity to a cell. @param energy not negative; relative to the activity after the last iteration,
  /// which summed to 1.
  void inject(const PoseCell& cell, double energy);
  /// Adds activity about a position: divided among the eight cells around it, so that its mean is there.
  void injectAt(const PoseCellEstimate& where, double energy);

  /// Replaces the activity, normalises it to sum 1, and updates the estimate.
  /// @throws std::invalid_argument if the shape differs, a cell is negative or not finite, or the sum is not
  /// positive.
  void setActivity(const ActivityGrid& activity);

  /// Best estimate after the last step; the centre cell before the first.
  const PoseCellEstimate& estimate() const { return estimate_; }
  const ActivityGrid& activity() const { return grid_; }
  /// Number of times that all activity had died.
  std::uint64_t reseeds() const { return reseeds_; }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

 private:
  double iterate();
  void move(double distance, double rotation, double sum);
  void reseed();

  ActivityGrid grid_;
  Attractor attractor_;
  PathIntegrator path_integrator_;
  PeakDecoder peak_decoder_;
  PoseCellEstimate estimate_;
  std::uint64_t reseeds_ = 0;
  /// Sum that the model's activity would have. The model normalises only in step 4, this class after every
  /// call. The factor makes the next global inhibition act as it would in the model.
  double model_sum_ = 1.0;
};

}  // namespace ratslam
