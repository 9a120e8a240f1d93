/// ratslam_lv: camera/image -> LocalView/Template by the local view cells (MODEL section 1), and
/// LocalView/View to look at. Where image geometry verifies recalls (vt_verify), also camera/camera_info ->
/// LocalView/RecallGeometry, one message an image.
#pragma once

#include <memory>
#include <optional>

#include "ratslam/local_view/local_view_cells.h"
#include "ratslam/system/recall_check.h"
#include "ratslam_ros/support/calibrated_images.h"
#include "ratslam_ros/support/lazy_picture.h"
#include "ratslam_ros/support/node_parameters.h"
#include "ratslam_ros/support/start_gate.h"

namespace ratslam {

class LocalViewNode {
 public:
  /// @throws std::invalid_argument for bad parameters
  LocalViewNode(ros::NodeHandle handle, const ParameterMap& parameters);

 private:
  CalibratedImages::CameraHandler cameraHandler();
  void onImage(const std_msgs::Header& header, const cv::Mat& image);
  ViewEvent observe(Stamp stamp, const cv::Mat& image);

  NodeParams params_;
  RecallGeometryParams recall_params_;
  LocalViewCells cells_;
  std::unique_ptr<RecallCheck> recall_check_;  ///< where vt_verify asks for it, once the camera is known
  std::vector<ros::Publisher> outputs_;        ///< templates and, where recalls are verified, geometry
  LazyPicture picture_;
  CalibratedImages images_;
  std::optional<StartGate> gate_;
  ros::WallTimer watch_timer_;
};

}  // namespace ratslam
