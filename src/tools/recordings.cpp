#include "recordings.h"

#include <filesystem>
#include <stdexcept>

#include "ratslam/dataset/kitti_folder.h"
#include "ratslam/dataset/recorder_folder.h"

namespace ratslam {

std::unique_ptr<Recording> openRecording(const std::string& path, const RecordingOptions& options) {
  namespace fs = std::filesystem;
  if (!fs::exists(path)) throw std::runtime_error(path + ": no such file or folder");
  if (fs::is_directory(path)) {
    if (options.with_odometry) {
      throw std::runtime_error(path + ": a folder has no odometry topic; give --odometry profile or a CSV file");
    }
    if (fs::is_directory(path + "/image_0")) return std::make_unique<KittiFolder>(path);
    if (RecorderFolder::recognises(path)) return std::make_unique<RecorderFolder>(path);
    throw std::runtime_error(path + ": neither a KITTI sequence (image_0/, times.txt) nor a recorder's folder " +
                             "(images/, data_image.txt)");
  }
  throw std::runtime_error(path + ": not a folder");
}

}  // namespace ratslam
