/// A sequence folder of the KITTI odometry benchmark: image_0/000000.png (or .jpg), times.txt, calib.txt.
///
/// Missing images do not shift the times of the others (timesOf). calib.txt is read only when camera() is called. Its
/// projection is P0, or P_rect_00 in raw drives; for image_2 it is P2.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ratslam/camera/image_decoding.h"
#include "ratslam/dataset/recording.h"

namespace ratslam {

class KittiFolder : public Recording {
 public:
  /// @param image_folder  the folder of images within `folder`; "." if they are in `folder` itself
  /// @throws std::runtime_error naming the file or folder that is missing, empty or malformed, or whose times do not
  /// rise or do not fit the images
  explicit KittiFolder(const std::string& folder, const std::string& image_folder = "image_0",
                       const ImageLimits& limits = {});

  std::optional<RecordedItem> next() override;
  std::size_t imageCount() const override { return images_.size(); }
  /// None without calib.txt. @throws std::runtime_error naming the file if it has no usable projection
  std::optional<CameraModel> camera() const override;
  std::vector<std::string> remarks() const override { return remarks_; }

 private:
  cv::Size imageSize() const;

  std::string folder_;
  int camera_number_ = 0;
  std::vector<std::string> images_;
  std::vector<Stamp> stamps_;
  std::vector<std::string> remarks_;
  ImageLimits limits_;
  std::size_t next_ = 0;
};

}  // namespace ratslam
