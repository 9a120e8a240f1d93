/// The composite picture of every image of a run (composite.h) as a video file.
///
/// The file's ending chooses container and codec: .mp4 MPEG-4, .avi Motion JPEG. What is drawn is a function
/// of the run alone.
#pragma once

#include <opencv2/videoio.hpp>
#include <string>

#include "ratslam/system/pipeline.h"
#include "ratslam/view/draw_activity.h"

namespace ratslam {

/// Draws the system while it runs.
class RunPicture {
 public:
  /// What an image or a sample of odometry has set in motion; to be told all of it, for the pose cells'
  /// trail.
  void follow(const Pipeline::Progress& progress);
  /// The system after `image`, which made the last view event followed. kCompositeWidth x kCompositeHeight,
  /// 8-bit BGR.
  cv::Mat draw(const Pipeline& pipeline, const cv::Mat& image) const;

 private:
  ActivityTrail trail_;
  ViewEvent view_;
};

class RunVideo {
 public:
  /// @param frame_rate  [1/s] at which it is to be shown
  /// @throws std::runtime_error naming the file where its ending is another, or it or its codec cannot be
  /// opened
  RunVideo(const std::string& path, double frame_rate);

  ~RunVideo();
  RunVideo(const RunVideo&) = delete;
  RunVideo& operator=(const RunVideo&) = delete;

  void follow(const Pipeline::Progress& progress) { picture_.follow(progress); }
  /// Appends the picture of the system after `image`.
  void add(const Pipeline& pipeline, const cv::Mat& image);
  /// Ends the video and puts it in its place.
  /// @throws std::runtime_error naming the file where not all of it was written: the writer itself says nothing
  void finish();

 private:
  std::string path_;
  std::string part_;  ///< where it is written until it is whole
  RunPicture picture_;
  cv::VideoWriter writer_;
  std::size_t frames_ = 0;
};

}  // namespace ratslam
