/// Local view cells fed by frames, with image geometry where it verifies recalls (vt_verify).
///
/// A frame that shows nothing (frozen, without texture) learns and recalls nothing: its event has no view, so
/// that the pose cells keep up with its stamp and the odometry alone moves them.
#pragma once

#include <memory>
#include <optional>

#include "ratslam/camera/image_frame.h"
#include "ratslam/local_view/local_view_cells.h"
#include "ratslam/system/recall_check.h"

namespace ratslam {

/// What a frame gave.
struct ViewObservation {
  ViewEvent view;
  /// Where recalls are verified, one for each frame; inliers 0 where nothing was measured.
  std::optional<RecallGeometry> geometry;
};

class LocalViewStage {
 public:
  /// @throws std::invalid_argument for bad parameters
  LocalViewStage(const LocalViewParams& params, const RecallGeometryParams& recall_params);

  /// Whether it cannot observe before it has a camera.
  bool needsCamera() const { return recall_params_.verifies() && !recall_check_; }
  /// To be called once, before the first frame, where recalls are verified; else it does nothing.
  /// @throws std::invalid_argument for a bad camera
  void setCamera(const CameraModel& camera);

  /// @throws std::invalid_argument as LocalViewCells::observe does; std::logic_error without its camera
  ViewObservation observe(const ImageFrame& frame);

  const LocalViewCells& cells() const { return cells_; }

 private:
  RecallGeometryParams recall_params_;
  LocalViewCells cells_;
  std::unique_ptr<RecallCheck> recall_check_;
};

}  // namespace ratslam
