/// Registry of the kinds of recordings that can be read.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "ratslam/camera/image_decoding.h"
#include "ratslam/dataset/recording.h"

namespace ratslam {

/// Options for opening a recording.
struct RecordingOptions {
  std::string image_topic;     ///< of a bag; empty: the only one it has
  std::string odometry_topic;  ///< of a bag; empty: the only one it has
  bool with_odometry = false;  ///< also read the bag's odometry
  std::string image_folder;    ///< within a KITTI sequence; ".": the sequence itself; empty: image_0
  ImageLimits limits;
  int rotate_deg = 0;  ///< turn the images of a recorder's folder clockwise
};

/// A kind of recording.
struct RecordingKind {
  std::string what;  ///< "a KITTI sequence (image_0/, times.txt)"
  std::function<bool(const std::string& path, const RecordingOptions&)> recognises;
  /// @throws std::exception naming what is missing or malformed, or the option that this kind does not have
  std::function<std::unique_ptr<Recording>(const std::string& path, const RecordingOptions&)> open;
};

class RecordingRegistry {
 public:
  /// Adds a kind. The first one that recognises a path opens it.
  void add(RecordingKind kind) { kinds_.push_back(std::move(kind)); }

  /// @throws std::runtime_error as the kind does, or listing all kinds if none recognises the path
  std::unique_ptr<Recording> open(const std::string& path, const RecordingOptions& options) const;

 private:
  std::vector<RecordingKind> kinds_;
};

/// The kinds that are folders; bags need ROS.
RecordingRegistry folderRecordings();

}  // namespace ratslam
