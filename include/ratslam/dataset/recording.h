/// A recorded drive, item by item in the order of its time: images still encoded, and odometry where it has
/// some.
///
/// Decoding is left to `DecodeAhead`, which does it on other threads while the system works on earlier frames
/// and hands the items out in their original order.
#pragma once

#include <condition_variable>
#include <deque>
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
  std::function<cv::Mat()> decode;  ///< an empty matrix or an exception where the image is corrupt
};

using RecordedItem = std::variant<RecordedImage, OdometrySample>;

class Recording {
 public:
  virtual ~Recording() = default;
  /// The next item, none at the end.
  virtual std::optional<RecordedItem> next() = 0;
  /// How many images it has in all.
  virtual std::size_t imageCount() const = 0;
  /// The calibration that it brings along, where it has one. @throws std::exception naming file or topic where
  /// that is malformed: to be asked for by those alone who need it
  virtual std::optional<CameraModel> camera() const { return std::nullopt; }
  /// What was found odd in it and passed over, a line each.
  virtual std::vector<std::string> remarks() const { return {}; }
};

struct DecodedImage {
  Stamp stamp = 0;
  std::string name;
  cv::Mat image;      ///< empty where it is corrupt
  std::string error;  ///< why it is corrupt
};

/// Never throws: what goes wrong becomes the error.
DecodedImage decodeNow(const RecordedImage& encoded);

using DecodedItem = std::variant<DecodedImage, OdometrySample>;

/// Decodes images some way ahead of the caller. The order and content of what comes out do not depend on
/// timing.
class DecodeAhead {
 public:
  /// @param recording  must outlive this object and is used by it alone
  /// @param threads    decoding threads, at least 1
  DecodeAhead(Recording& recording, int threads);
  ~DecodeAhead();
  DecodeAhead(const DecodeAhead&) = delete;
  DecodeAhead& operator=(const DecodeAhead&) = delete;

  /// The next item, none at the end. @throws what the recording threw while reading
  std::optional<DecodedItem> next();

  /// Time that all threads together have spent decoding so far [s]. Not a result: it never influences one.
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
  bool stopping_ = false;
  double decoding_seconds_ = 0.0;
  std::size_t depth_;
  std::vector<std::thread> threads_;
};

}  // namespace ratslam
