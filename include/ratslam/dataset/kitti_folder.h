/// A sequence folder of the KITTI odometry benchmark: image_0/000000.png (or .jpg), times.txt, calib.txt.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/dataset/recording.h"

namespace ratslam {

class KittiFolder : public Recording {
 public:
  /// @throws std::runtime_error naming the file or folder that is missing, empty or malformed, or where
  /// images and
  ///         times.txt do not have the same number
  explicit KittiFolder(const std::string& folder);

  std::optional<RecordedItem> next() override;
  std::size_t imageCount() const override { return images_.size(); }

  /// First row of calib.txt: projection of the left grey camera, 3x4 row by row, where the file is there.
  std::optional<std::array<double, 12>> projection() const { return projection_; }

 private:
  std::vector<std::string> images_;
  std::vector<Stamp> stamps_;
  std::optional<std::array<double, 12>> projection_;
  std::size_t next_ = 0;
};

/// Odometry from a CSV file with the columns frame,stamp,linear_x,angular_z (names in the first line; more
/// columns and any order of them are fine). @throws std::runtime_error naming file, line and reason
std::vector<OdometrySample> readOdometryCsv(const std::string& path);

/// A recording with odometry of its own laid into it by stamp; what the recording itself has of odometry is
/// left out. At one stamp the odometry comes first.
class RecordingWithOdometry : public Recording {
 public:
  RecordingWithOdometry(Recording& images, std::vector<OdometrySample> odometry)
      : images_(images), odometry_(std::move(odometry)) {}

  std::optional<RecordedItem> next() override;
  std::size_t imageCount() const override { return images_.imageCount(); }

 private:
  Recording& images_;
  std::vector<OdometrySample> odometry_;
  std::size_t next_odometry_ = 0;
  std::optional<RecordedItem> waiting_image_;
};

}  // namespace ratslam
