/// Odometry files, and recordings of images that take their odometry from such a file.
#pragma once

#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/dataset/recording.h"

namespace ratslam {

/// Reads odometry from a CSV file with the columns frame,stamp,linear_x,angular_z. Their names are in the first line;
/// their order does not matter, and more columns are allowed. If the odometry has poses, further columns hold the 3x4
/// matrix [R|t]: r11,r12,r13,x,r21,r22,r23,y,r31,r32,r33,z. Optional columns, which may be empty:
///
///     linear_y                                       motion to the left, which is not used and may be warned about
///     cov_11 ... cov_66                              covariance of the twist, row by row
///     unit_anchor,unit_walk,epoch,bridged            UnitOfLength, epoch, 1 where the motion was predicted
///     correction_from,correction_to,correction_way,correction_r11 ... correction_z,
///     correction_cov_11 ... correction_cov_66        correction_way has "STAMP r11 ... z;" for each pose
///
/// The columns of one line, and those of the poses, are all there or none of them is.
///
/// @throws std::runtime_error naming file, line and reason
std::vector<OdometrySample> readOdometryCsv(const std::string& path);

/// Writes samples as CSV, from which readOdometryCsv restores the same bits. Poses are written if all samples have one.
/// The stream's precision is not changed.
void writeOdometryCsv(std::ostream& file, const std::vector<OdometrySample>& samples);
/// @throws std::runtime_error naming the file if it cannot be written; an old file remains then
void writeOdometryCsv(const std::string& path, const std::vector<OdometrySample>& samples);

/// A recording with the odometry of a file, merged by stamp. Odometry of the recording itself is left out. At equal
/// stamps the odometry comes first.
class RecordingWithOdometry : public Recording {
 public:
  RecordingWithOdometry(std::unique_ptr<Recording> images, std::vector<OdometrySample> odometry)
      : images_(std::move(images)), odometry_(std::move(odometry)) {}

  std::optional<RecordedItem> next() override;
  std::size_t imageCount() const override { return images_->imageCount(); }
  std::optional<CameraModel> camera() const override { return images_->camera(); }
  std::vector<std::string> remarks() const override { return images_->remarks(); }

 private:
  void fetchImages();
  Stamp stampForOdometry() const;

  std::unique_ptr<Recording> images_;
  std::vector<OdometrySample> odometry_;
  std::size_t next_odometry_ = 0;
  std::optional<RecordedImage> waiting_image_;
  std::optional<RecordedImage> image_after_;
  std::exception_ptr failure_;  ///< of reading the image after; thrown once the waiting one is handed out
  std::optional<Stamp> last_image_;
};

}  // namespace ratslam
