/// Checkpoints of one of our odometries in ~map_dir. If the next image follows the last one, a restarted node continues
/// where it was. Otherwise the pose continues, and the motion in between is marked as unmeasured.
#pragma once

#include "ratslam/odometry/source.h"
#include "ratslam/system/image_stage.h"
#include "ratslam_ros/support/image_subscriber.h"
#include "ratslam_ros/support/node_checkpoints.h"
#include "ratslam_ros/support/odometry_publisher.h"

namespace ratslam {

class OdometryCheckpoints {
 public:
  /// @param parameters  of the source   @param source,publisher,images  outlive this
  OdometryCheckpoints(const NodeParams& params, const ImageStageParams& image_params,
                      const std::map<std::string, std::string>& parameters, OdometrySource& source,
                      OdometryPublisher& publisher, ImageSubscriber& images);

  /// @throws std::runtime_error if there is a checkpoint with other parameters
  void resume();
  /// To be called before a frame is tracked. @return the frame for the source
  ImageFrame before(const ImageFrame& frame);
  /// To be called when the node ends.
  void finish();

 private:
  void save(State& state) const;

  double longest_gap_;  ///< longest time between two images that follow each other [s]
  OdometrySource& source_;
  OdometryPublisher& publisher_;
  ImageSubscriber& images_;
  NodeCheckpoints checkpoints_;
  bool resumed_ = false;  ///< resumed from a checkpoint, and no image has come since
};

}  // namespace ratslam
