/// Odometry from a file, laid into a recording of images.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/dataset/recording.h"

namespace ratslam {

/// Odometry from a CSV file with the columns frame,stamp,linear_x,angular_z (names in the first line; more
/// columns and any order of them are fine) and, where the odometry knows its pose, the 3x4 matrix [R|t] of
/// it: r11,r12,r13,x,r21,r22,r23,y,r31,r32,r33,z (all or none). What the odometry says of itself stands in
/// further columns, empty where a sample does not say it:
///
///     cov_11 ... cov_66                              covariance of the twist, row by row
///     unit_anchor,unit_walk,epoch,bridged            UnitOfLength, epoch, 1 where the motion was predicted
///     correction_from,correction_to,correction_way,correction_r11 ... correction_z,
///     correction_cov_11 ... correction_cov_66        the way as "STAMP r11 ... z;" for each of its poses
///
/// @throws std::runtime_error naming file, line and reason
std::vector<OdometrySample> readOdometryCsv(const std::string& path);

/// Writes what readOdometryCsv reads, such that reading it back gives the same bits; poses where all samples
/// have one. The stream's own precision is kept.
void writeOdometryCsv(std::ostream& file, const std::vector<OdometrySample>& samples);
/// @throws std::runtime_error naming the file where it cannot be written; what was there stays then
void writeOdometryCsv(const std::string& path, const std::vector<OdometrySample>& samples);

/// A recording with odometry of its own laid into it by stamp; what the recording itself has of odometry is
/// left out. At one stamp the odometry comes first.
class RecordingWithOdometry : public Recording {
 public:
  RecordingWithOdometry(std::unique_ptr<Recording> images, std::vector<OdometrySample> odometry)
      : images_(std::move(images)), odometry_(std::move(odometry)) {}

  std::optional<RecordedItem> next() override;
  std::size_t imageCount() const override { return images_->imageCount(); }
  std::optional<CameraModel> camera() const override { return images_->camera(); }
  std::vector<std::string> remarks() const override { return images_->remarks(); }

 private:
  std::unique_ptr<Recording> images_;
  std::vector<OdometrySample> odometry_;
  std::size_t next_odometry_ = 0;
  std::optional<RecordedItem> waiting_image_;
};

}  // namespace ratslam
