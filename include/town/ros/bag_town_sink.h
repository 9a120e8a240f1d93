/// A synthetic drive written as a bag: camera/image (or camera/image/compressed for JPEG),
/// camera/camera_info, ground_truth, and, if the drive has them, odom, gps and imu; the camera under
/// base_link on /tf_static.
///
/// The bag is begun with the first frame, as OUT.part, and has its name once it is complete. One that is not finished goes.
///
/// Stamps are absolute (the options' start). Poses are those of base_link (x forward, y left, z up), which
/// lies in the camera's centre, in the frame "world": base_link at the first image.
#pragma once

#include <rosbag/bag.h>

#include <memory>
#include <optional>
#include <string>

#include "town/town_sink.h"

namespace ratslam {

class BagTownSink : public TownSink {
 public:
  /// @param root  namespace of the topics
  /// @throws std::invalid_argument if options.out exists, an option has no effect on a bag, or root is no name of ROS
  /// @throws std::runtime_error if options.out cannot be written
  BagTownSink(const TownOptions& options, const std::string& root);
  ~BagTownSink() override;

  /// @throws std::runtime_error if the bag cannot be written
  void add(const TownFrame& frame) override;
  void finish() override;

 private:
  void begin();
  bool closed();
  template <class Message>
  void write(const std::string& topic, Stamp stamp, const Message& message);
  void writeCamera(const TownFrame& frame, Stamp stamp);
  void writeTruth(const TownFrame& frame, Stamp stamp);
  void writeSensors(const TownFrame& frame, Stamp stamp);

  TownOptions options_;
  TownCamera camera_;
  std::string root_;
  Stamp start_;
  std::string part_;
  std::unique_ptr<rosbag::Bag> bag_;  ///< from the first frame until the bag is finished
  std::optional<Eigen::Isometry3d> first_camera_pose_;
  struct Truth {
    Stamp stamp = 0;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  };
  std::optional<Truth> last_truth_;
};

}  // namespace ratslam
