#include "recordings.h"

#include <filesystem>
#include <stdexcept>

#include "ratslam/dataset/kitti_folder.h"
#include "ratslam/dataset/recorder_folder.h"
#include "ratslam_ros/bag/bag_recording.h"

namespace ratslam {

std::unique_ptr<Recording> openRecording(const std::string& path, const RecordingOptions& options) {
  namespace fs = std::filesystem;
  const bool recorder =
      fs::is_directory(path) && !fs::is_directory(path + "/image_0") && RecorderFolder::recognises(path);
  if (options.rotate_deg != 0 && !recorder) {
    throw std::runtime_error(path + ": --rotate " + std::to_string(options.rotate_deg) +
                             " is for a recorder's folder; a bag or KITTI sequence has its images upright");
  }
  if (!fs::is_directory(path)) {
    return std::make_unique<BagRecording>(
        path, BagTopics{options.image_topic, options.odometry_topic, options.with_odometry}, options.limits);
  }
  if (options.with_odometry) {
    throw std::runtime_error(path +
                             ": a folder has no odometry topic; give --odometry profile, orb or a CSV file");
  }
  if (fs::is_directory(path + "/image_0")) return std::make_unique<KittiFolder>(path, options.limits);
  if (recorder) return std::make_unique<RecorderFolder>(path, options.rotate_deg, options.limits);
  throw std::runtime_error(path +
                           ": neither a KITTI sequence (image_0/, times.txt) nor a recorder's folder " +
                           "(images/, data_image.txt)");
}

std::optional<CameraModel> cameraOf(const Recording& recording) {
  if (const auto* kitti = dynamic_cast<const KittiFolder*>(&recording)) {
    const auto p = kitti->projection();
    if (!p) return std::nullopt;
    const cv::Size size = kitti->imageSize();
    return CameraModel{size.width, size.height, (*p)[0], (*p)[5], (*p)[2], (*p)[6], LensModel::kNone, {}};
  }
  if (const auto* bag = dynamic_cast<const BagRecording*>(&recording)) return bag->camera();
  return std::nullopt;
}

}  // namespace ratslam
