#include "bags.h"

#include <filesystem>
#include <stdexcept>

#include "ratslam_ros/bag/bag_recording.h"
#include "town/ros/bag_town_sink.h"

namespace ratslam {

RecordingKind bagRecordings() {
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

std::unique_ptr<TownSink> makeBagSink(const TownOptions& options, const std::string& root) {
  return std::make_unique<BagTownSink>(options, root);
}

}  // namespace ratslam
