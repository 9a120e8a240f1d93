#include "recordings.h"

#include <filesystem>
#include <stdexcept>

#include "ratslam_ros/bag/bag_recording.h"

namespace ratslam {
namespace {

/// Whatever is no folder, so that a file that is no bag is told so.
RecordingKind bag() {
  RecordingKind kind;
  kind.what = "a bag";
  kind.recognises = [](const std::string& path, const RecordingOptions&) {
    return !std::filesystem::is_directory(path);
  };
  kind.open = [](const std::string& path, const RecordingOptions& options) {
    if (options.rotate_deg != 0) {
      throw std::runtime_error(path + ": --rotate " + std::to_string(options.rotate_deg) +
                               " is for a recorder's folder; a bag has its images upright");
    }
    if (!options.image_folder.empty()) {
      throw std::runtime_error(path + ": --image-folder " + options.image_folder +
                               " is for a folder; a bag has --image-topic");
    }
    return std::make_unique<BagRecording>(
        path, BagTopics{options.image_topic, options.odometry_topic, options.with_odometry}, options.limits);
  };
  return kind;
}

}  // namespace

std::unique_ptr<Recording> openRecording(const std::string& path, const RecordingOptions& options) {
  RecordingRegistry registry = folderRecordings();
  registry.add(bag());
  return registry.open(path, options);
}

}  // namespace ratslam
