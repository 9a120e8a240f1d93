#include "ratslam/dataset/registry.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "ratslam/dataset/image_folder.h"
#include "ratslam/dataset/kitti_folder.h"
#include "ratslam/dataset/recorder_folder.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

/// Whether a path is a folder. False also if that is unknown: a link to itself, a folder without permission.
bool isFolder(const std::string& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

void refuseTopics(const std::string& path, const RecordingOptions& options) {
  for (const auto& [option, topic] : {std::pair("--image-topic ", options.image_topic),
                                      std::pair("--odometry-topic ", options.odometry_topic)}) {
    if (!topic.empty())
      throw std::runtime_error(path + ": " + option + topic + " is for a bag; a folder has no topics");
  }
  if (!options.with_odometry) return;
  throw std::runtime_error(path +
                           ": a folder has no odometry topic; give --odometry profile, orb or a CSV file");
}

RecordingKind kittiSequence() {
  RecordingKind kind;
  kind.what = "a KITTI sequence (image_0/, times.txt)";
  kind.recognises = [](const std::string& path, const RecordingOptions& options) {
    return isFolder(path) && (!options.image_folder.empty() || isFolder(path + "/image_0"));
  };
  kind.open = [](const std::string& path, const RecordingOptions& options) {
    refuseTopics(path, options);
    if (options.rotate_deg != 0) {
      throw std::runtime_error(path + ": --rotate " + std::to_string(options.rotate_deg) +
                               " is for a recorder's folder; a KITTI sequence has its images upright");
    }
    return std::make_unique<KittiFolder>(
        path, options.image_folder.empty() ? "image_0" : options.image_folder, options.limits);
  };
  return kind;
}

RecordingKind recorderFolder() {
  RecordingKind kind;
  kind.what = "a recorder's folder (images/, data_image.txt)";
  kind.recognises = [](const std::string& path, const RecordingOptions&) {
    return isFolder(path) && RecorderFolder::recognises(path);
  };
  kind.open = [](const std::string& path, const RecordingOptions& options) {
    refuseTopics(path, options);
    return std::make_unique<RecorderFolder>(path, options.rotate_deg, options.limits);
  };
  return kind;
}

/// Hint for a folder that is no recording: what it is, and the option or tool that reads it.
std::string hintFor(const std::string& path) {
  if (!isFolder(path)) return "";
  if (isFolder(path + "/image_00")) return "; it is a raw drive of KITTI, of which kitti_to_bag makes a bag";
  if (fs::exists(path + "/manifest.json")) {
    return "; it is a donkey car's tub, of which donkey_to_kitti makes a sequence";
  }
  if (fs::exists(path + "/metadata.yaml")) {
    return "; it seems to be a bag of ROS 2, of which rosbags-convert makes one of ROS 1";
  }
  std::vector<std::string> folders, bags;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path, error)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_directory(error) && name.rfind("image", 0) == 0) folders.push_back(name);
    if (entry.path().extension() == ".bag") bags.push_back(name);
  }
  if (!folders.empty()) {
    const std::string first = *std::min_element(folders.begin(), folders.end());
    return "; its images in " + first + "/ are read with --image-folder " + first;
  }
  if (!bags.empty()) {
    return "; bags lie in it: name one of them, such as " + *std::min_element(bags.begin(), bags.end());
  }
  if (fs::exists(path + "/times.txt")) return "; images that lie in it itself are read with --image-folder .";
  if (!imagesIn(path).empty()) {
    return "; images lie in it itself: with a times.txt beside them, a time in seconds for each, "
           "--image-folder . reads them";
  }
  return "";
}

}  // namespace

std::unique_ptr<Recording> RecordingRegistry::open(const std::string& path,
                                                   const RecordingOptions& options) const {
  for (const RecordingKind& kind : kinds_) {
    if (kind.recognises(path, options)) return kind.open(path, options);
  }
  if (!fs::exists(path))
    throw std::runtime_error(path + ": cannot open this recording: no such file or folder");
  std::string kinds;
  for (const RecordingKind& kind : kinds_) kinds += (kinds.empty() ? "neither " : " nor ") + kind.what;
  throw std::runtime_error(path + ": " + kinds + hintFor(path));
}

RecordingRegistry folderRecordings() {
  RecordingRegistry registry;
  registry.add(kittiSequence());
  registry.add(recorderFolder());
  return registry;
}

}  // namespace ratslam
