/// ratslam_lv: camera/image -> LocalView/Template by the local view cells (MODEL section 1), and
/// LocalView/View to look at.
#pragma once

#include <optional>

#include "ratslam/local_view/local_view_cells.h"
#include "ratslam_ros/image_subscriber.h"
#include "ratslam_ros/lazy_picture.h"
#include "ratslam_ros/node_parameters.h"
#include "ratslam_ros/start_gate.h"

namespace ratslam {

class LocalViewNode {
 public:
  /// @throws std::invalid_argument for bad parameters
  LocalViewNode(ros::NodeHandle handle, const ParameterMap& parameters);

 private:
  void onImage(const std_msgs::Header& header, const cv::Mat& image);

  NodeParams params_;
  LocalViewCells cells_;
  ros::Publisher template_publisher_;
  LazyPicture picture_;
  ImageSubscriber images_;
  std::optional<StartGate> gate_;
  ros::WallTimer watch_timer_;
};

}  // namespace ratslam
