/// The composite picture of every image of a run (composite.h) as a video file.
///
/// The file's ending selects container and codec: .mp4 MPEG-4, .avi Motion JPEG. The pictures are a function of the run
/// alone.
#pragma once

#include <opencv2/videoio.hpp>
#include <string>

#include "ratslam/system/pipeline.h"
#include "ratslam/view/draw_activity.h"

namespace ratslam {

/// Draws the system while it runs.
class RunPicture {
 public:
  /// To be called with every progress of the pipeline, for the pose cells' trail.
  void follow(const Pipeline::Progress& progress);
  /// The system after `image`, whose view event was the last one followed. kCompositeWidth x kCompositeHeight, 8-bit BGR.
  cv::Mat draw(const Pipeline& pipeline, const cv::Mat& image) const;

 private:
  ActivityTrail trail_;
  ViewEvent view_;
};

class RunVideo {
 public:
  /// @param frame_rate  of the video [1/s]
  /// @throws std::runtime_error naming the file if its ending is unknown, or it or its codec cannot be opened
  RunVideo(const std::string& path, double frame_rate);

  ~RunVideo();
  RunVideo(const RunVideo&) = delete;
  RunVideo& operator=(const RunVideo&) = delete;

  void follow(const Pipeline::Progress& progress) { picture_.follow(progress); }
  /// Appends the picture of the system after `image`.
  void add(const Pipeline& pipeline, const cv::Mat& image);
  /// Ends and renames the video.
  /// @throws std::runtime_error naming the file if it was not written completely; OpenCV's writer does not report that
  void finish();

 private:
  std::string path_;
  std::string part_;  ///< temporary name until the video is complete
  RunPicture picture_;
  cv::VideoWriter writer_;
  std::size_t frames_ = 0;
};

}  // namespace ratslam
