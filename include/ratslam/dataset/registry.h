/// The forms of recordings that can be read: one loader a file, one line here each.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "ratslam/camera/image_decoding.h"
#include "ratslam/dataset/recording.h"

namespace ratslam {

/// What a user may say about a recording beside its path.
struct RecordingOptions {
  std::string image_topic;     ///< of a bag; empty: the only one it has
  std::string odometry_topic;  ///< of a bag; empty: the only one it has
  bool with_odometry = false;  ///< hand out the bag's odometry among the images
  std::string image_folder;    ///< within a KITTI sequence, "." for itself; empty: image_0
  ImageLimits limits;
  int rotate_deg = 0;  ///< turn the images of a recorder's folder clockwise
};

/// One form of recordings.
struct RecordingKind {
  std::string what;  ///< "a KITTI sequence (image_0/, times.txt)"
  std::function<bool(const std::string& path, const RecordingOptions&)> recognises;
  /// @throws std::exception saying what is missing or malformed, or which option is not for this form
  std::function<std::unique_ptr<Recording>(const std::string& path, const RecordingOptions&)> open;
};

class RecordingRegistry {
 public:
  /// Kinds are asked in the order in which they were added.
  void add(RecordingKind kind) { kinds_.push_back(std::move(kind)); }

  /// @throws std::runtime_error as the kind does, or naming all kinds where none recognises the path
  std::unique_ptr<Recording> open(const std::string& path, const RecordingOptions& options) const;

 private:
  std::vector<RecordingKind> kinds_;
};

/// The folders that the core reads.
RecordingRegistry folderRecordings();

}  // namespace ratslam
