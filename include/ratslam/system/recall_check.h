/// Verification of recalls by image geometry: connects LocalViewCells with RecallGeometryEstimator.
#pragma once

#include "ratslam/camera/camera_model.h"
#include "ratslam/local_view/local_view_cells.h"
#include "ratslam/local_view/recall/recall_geometry_estimator.h"

namespace ratslam {

class RecallCheck : public RecallVerifier {
 public:
  /// @throws std::invalid_argument for bad parameters or a bad camera
  RecallCheck(const RecallGeometryParams& params, const CameraModel& camera);

  /// The view event of an image. The measured geometry is kept in the cells.
  /// @throws std::invalid_argument as LocalViewCells::observe does
  ViewEvent observe(LocalViewCells& cells, Stamp stamp, const View& view, const cv::Mat& image,
                    const ViewMotion& motion);

  /// @throws std::invalid_argument for an image whose size is not the camera's
  void requireSize(const cv::Mat& image) const { estimator_.requireSize(image); }

  std::optional<RecallGeometry> verify(Stamp stamp, const cv::Mat& image, std::uint32_t view_id) override {
    return estimator_.verify(stamp, image, view_id);
  }
  void learned(Stamp stamp, const cv::Mat& image, std::uint32_t view_id) override {
    estimator_.learned(stamp, image, view_id);
  }

  void save(State& state) const { estimator_.save(state); }
  /// @throws std::runtime_error naming what is missing or does not fit
  void load(const State& state) { estimator_.load(state); }

 private:
  RecallGeometryEstimator estimator_;
};

}  // namespace ratslam
