/// A bag as a recording: its images and, on request, its odometry in the order of recording. Messages are decoded as in
/// the nodes. The quality of the odometry is read from the topic beside it (odom -> odom_quality), if the bag has it, and
/// paired with the samples as in the nodes (quality_pairing.h): the laps of a looped recording repeat their stamps.
#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <memory>
#include <optional>
#include <string>

#include "ratslam/camera/camera_model.h"
#include "ratslam/camera/image_decoding.h"
#include "ratslam/dataset/recording.h"
#include "ratslam_ros/bag/bag_check.h"
#include "ratslam_ros/support/quality_pairing.h"

namespace ratslam {

struct BagTopics {
  std::string images;          ///< sensor_msgs/Image or CompressedImage; empty: the only such topic
  std::string odometry;        ///< nav_msgs/Odometry; empty: the only such topic named .../odom
  bool with_odometry = false;  ///< whether to read odometry
};

class BagRecording : public Recording {
 public:
  /// @throws std::runtime_error with one line: the file is missing, empty, truncated, without an index (rosbag reindex)
  /// or no bag; or a topic is missing, of another type or not the only one (the line then lists the topics and types)
  BagRecording(const std::string& path, const BagTopics& topics, const ImageLimits& limits = {});

  /// @throws std::runtime_error naming the file if it cannot be read any further
  std::optional<RecordedItem> next() override;
  std::size_t imageCount() const override { return image_count_; }

  const BagTopics& topics() const { return topics_; }

  /// Calibration in the first usable camera_info message beside the images; none without such a topic.
  /// @throws std::runtime_error naming bag, topic and reason if none of its messages is usable
  std::optional<CameraModel> camera() const override;

 private:
  /// Sizes of the first readable images, the most frequent one first; one empty size if none is readable.
  std::vector<cv::Size> firstImageSizes() const;
  /// Prepares the pairing of samples and qualities, if the bag has qualities.
  void beginPairing();
  /// The next sample of odometry with its quality. Reads ahead until that has come, or cannot come any more.
  std::optional<OdometrySample> nextPaired();
  void hear(const rosbag::MessageInstance& instance);

  std::string path_;
  BagTopics topics_;
  ImageLimits limits_;
  rosbag::Bag bag_;
  mutable BagCheck check_;  ///< called before each message is read
  std::unique_ptr<rosbag::View> view_;
  rosbag::View::iterator position_;
  std::unique_ptr<rosbag::View> paired_view_;  ///< odometry and its quality; null if the bag has no qualities
  rosbag::View::iterator paired_position_;
  QualityPairing pairing_;
  std::size_t image_count_ = 0;
};

}  // namespace ratslam
