/// A recorded drive: encoded images and, if it has any, samples of odometry, in order of time.
///
/// `DecodeAhead` decodes the images on other threads while the system processes earlier ones. It hands out the items
/// in their original order.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/odometry/odometry.h"

namespace ratslam {

struct RecordedImage {
  Stamp stamp = 0;
  std::string name;                 ///< file or message, for error messages
  std::function<cv::Mat()> decode;  ///< gives an empty matrix or throws if the image is corrupt
};

using RecordedItem = std::variant<RecordedImage, OdometrySample>;

class Recording {
 public:
  virtual ~Recording() = default;
  /// The next item; none at the end.
  virtual std::optional<RecordedItem> next() = 0;
  /// Number of all images.
  virtual std::size_t imageCount() const = 0;
  /// The recording's calibration; none if it has none. To be called only if the calibration is needed.
  /// @throws std::exception naming file or topic if the calibration is malformed
  virtual std::optional<CameraModel> camera() const { return std::nullopt; }
  /// Irregularities that were ignored, a line each.
  virtual std::vector<std::string> remarks() const { return {}; }
};

struct DecodedImage {
  Stamp stamp = 0;
  std::string name;
  cv::Mat image;      ///< empty if it is corrupt
  std::string error;  ///< why it is corrupt
};

/// Decodes an image. Never throws: an exception becomes the error.
DecodedImage decodeNow(const RecordedImage& encoded);

using DecodedItem = std::variant<DecodedImage, OdometrySample>;

/// Decodes images ahead of the caller. Order and content of the items do not depend on timing.
class DecodeAhead {
 public:
  /// @param recording  must outlive this object; nobody else may use it meanwhile
  /// @param threads    decoding threads, at least 1
  DecodeAhead(Recording& recording, int threads);
  ~DecodeAhead();
  DecodeAhead(const DecodeAhead&) = delete;
  DecodeAhead& operator=(const DecodeAhead&) = delete;

  /// The next item; none at the end. @throws the exception of the recording if it could not read on, after all items
  /// before it
  std::optional<DecodedItem> next();

  /// Decoding time of all threads so far [s]. It never influences a result.
  double decodingSeconds() const;

 private:
  struct Slot {
    std::optional<RecordedImage> encoded;  ///< still to be decoded
    DecodedItem item;
    bool done = false;
  };

  void fill(std::unique_lock<std::mutex>& lock);
  void work();

  Recording& recording_;
  mutable std::mutex mutex_;
  std::condition_variable wake_workers_;
  std::condition_variable wake_reader_;
  std::deque<std::shared_ptr<Slot>> slots_;  ///< in the recording's order
  std::deque<std::shared_ptr<Slot>> to_decode_;
  bool at_end_ = false;
  std::exception_ptr failure_;  ///< why the recording ended early
  bool stopping_ = false;
  double decoding_seconds_ = 0.0;
  std::size_t depth_;
  std::vector<std::thread> threads_;
};

}  // namespace ratslam
