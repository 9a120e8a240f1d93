/// The continuous attractor network of the pose cells, eqs. (1) and (2). Source: docs/theory.md#pose-cells.
///
/// One step: local excitation, local inhibition, global inhibition, normalisation (attractor.h), path
/// integration (path_integration.h), best estimate (peak.h). Between the steps views inject activity.
#pragma once

#include <cstdint>

#include "ratslam/pose_cells/activity_grid.h"
#include "ratslam/pose_cells/attractor.h"
#include "ratslam/pose_cells/params.h"
#include "ratslam/pose_cells/path_integration.h"
#include "ratslam/pose_cells/peak.h"
#include "ratslam/simd/row_kernels.h"

namespace ratslam {

/// Activity of shape n_th x n_xy x n_xy, non-negative, that sums to 1 after every call.
/// It starts as 1 in the centre cell.
class PoseCellNetwork {
 public:
  /// @param level instruction set to use; results do not depend on it.
  /// @throws std::invalid_argument as PoseCellParams::validate.
  explicit PoseCellNetwork(const PoseCellParams& params, SimdLevel level = bestSimdLevel());

  /// One odometry step: attract, integratePath, and a new estimate.
  /// @param distance [m] along the heading, negative backwards; @param rotation [rad], CCW positive
  /// (REP-103).
  /// @throws std::invalid_argument if either is not finite; nothing has changed then.
  void step(double distance, double rotation);

  /// One iteration of the attractor. If all activity dies, it starts again at the last estimate.
  void attract();
  /// Moves the packet; the estimate stays as it was. @throws std::invalid_argument as step.
  void integratePath(double distance, double rotation);
  /// Adds activity to a cell. @param energy relative to what the last iteration left, which was 1; not
  /// negative.
  void inject(const PoseCell& cell, double energy);

  /// Replaces the activity, scaled so that it sums to 1, and takes the estimate from it.
  /// @throws std::invalid_argument if the shape differs, a cell is negative or not finite, or the sum is not
  /// positive.
  void setActivity(const ActivityGrid& activity);

  /// Where the robot was after the last step (the centre cell before the first).
  const PoseCellEstimate& estimate() const { return estimate_; }
  const ActivityGrid& activity() const { return grid_; }
  /// How often all activity had died.
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
  /// What the model, which normalises in step 4 only, would have as the sum: the next global inhibition is to
  /// bite as deep into the normalised activity kept here as it would into the model's.
  double model_sum_ = 1.0;
};

}  // namespace ratslam
