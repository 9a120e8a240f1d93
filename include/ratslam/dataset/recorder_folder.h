/// A folder of the Android dataset recorder, which recorded the paper's NN sequences.
///
/// `data_image.txt` has lines `ms,images/<ms>.jpeg` (Unix milliseconds at the camera's callback). Older recordings
/// have no such index; their images are named by nanoseconds. Lines may be out of order. Incomplete lines are left
/// out. Images are handed out by stamp; of equal stamps only the first existing file by name. A clock that was set
/// back during the recording is an error. scripts/recorder_to_bag uses the same rules.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "ratslam/camera/image_decoding.h"
#include "ratslam/dataset/recording.h"

namespace ratslam {

class RecorderFolder : public Recording {
 public:
  /// Whether a folder looks like the recorder's.
  static bool recognises(const std::string& folder);

  /// @param clockwise_deg rotation of the images: 0, 90, 180 or 270 (phones may store them in the sensor's axes)
  /// @throws std::runtime_error naming file, line and reason; std::invalid_argument for another angle
  explicit RecorderFolder(const std::string& folder, int clockwise_deg = 0, const ImageLimits& limits = {});

  std::optional<RecordedItem> next() override;
  std::size_t imageCount() const override { return images_.size(); }
  std::vector<std::string> remarks() const override { return remarks_; }

 private:
  using StampedPath = std::pair<Stamp, std::string>;

  void readIndex(const std::string& folder, const std::string& path);
  void readNames(const std::string& folder);
  void sortByStamp();

  std::vector<StampedPath> images_;  ///< by stamp
  std::vector<std::string> remarks_;
  std::string malformed_;  ///< the first malformed line, for the message if no line is usable
  std::size_t next_ = 0;
  int quarter_turns_ = 0;  ///< clockwise
  ImageLimits limits_;
};

}  // namespace ratslam
