/// A sequence folder of the KITTI odometry benchmark: image_0/000000.png (or .jpg), times.txt, calib.txt.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/camera/image_decoding.h"
#include "ratslam/dataset/recording.h"

namespace ratslam {

class KittiFolder : public Recording {
 public:
  /// @throws std::runtime_error naming the file or folder that is missing, empty or malformed, or where
  /// images and
  ///         times.txt do not have the same number
  explicit KittiFolder(const std::string& folder, const ImageLimits& limits = {});

  std::optional<RecordedItem> next() override;
  std::size_t imageCount() const override { return images_.size(); }

  /// First row of calib.txt: projection of the left grey camera, 3x4 row by row, where the file is there.
  std::optional<std::array<double, 12>> projection() const { return projection_; }

  /// Size of the first image that tells it [px]. @throws std::runtime_error where none does
  cv::Size imageSize() const;

 private:
  std::vector<std::string> images_;
  std::vector<Stamp> stamps_;
  std::optional<std::array<double, 12>> projection_;
  ImageLimits limits_;
  std::size_t next_ = 0;
};

}  // namespace ratslam
