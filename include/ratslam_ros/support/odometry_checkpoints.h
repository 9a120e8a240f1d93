/// Checkpoints of an odometry of ours in ~map_dir: a node that starts goes on where it was if the next image follows
/// the last one. Else the pose is carried on, and the way in between is said to be unmeasured.
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

  /// @throws std::runtime_error where there is a checkpoint of other parameters
  void resume();
  /// To be called before a frame is tracked. @return the frame as the source is to have it
  ImageFrame before(const ImageFrame& frame);
  /// To be called when the node ends.
  void finish();

 private:
  void save(State& state) const;

  double longest_gap_;  ///< between two images that follow each other [s]
  OdometrySource& source_;
  OdometryPublisher& publisher_;
  ImageSubscriber& images_;
  NodeCheckpoints checkpoints_;
  bool resumed_ = false;  ///< and no image has come since
};

}  // namespace ratslam
