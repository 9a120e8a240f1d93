#include "ratslam/dataset/kitti_folder.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include "ratslam/common/text_file.h"
#include "ratslam/dataset/csv.h"
#include "ratslam/dataset/image_folder.h"

namespace ratslam {
namespace {

constexpr double kLatestTime = 4294967296.0;  // 2^32: bound of ROS stamps [s]

using Projection = std::array<double, 12>;  // 3x4, row by row

std::vector<Stamp> readTimes(const std::string& path) {
  std::vector<Stamp> stamps;
  std::size_t risen = 0;
  for (const TextLine& line : readLines(path)) {
    const auto refuse = [&](const std::string& reason) {
      throw std::runtime_error(path + ":" + std::to_string(line.number) + ": '" + shown(line.text) + "' " +
                               reason);
    };
    double seconds = 0.0;
    if (!parseNumber(line.text, seconds)) {
      const bool comma = line.text.find(',') != std::string::npos;
      refuse(comma ? "is not a time in seconds; write decimals with points" : "is not a time in seconds");
    }
    if (seconds < 0.0 || seconds >= kLatestTime) refuse("lies outside 0 to 2^32 s; times are in seconds");
    const Stamp stamp = stampFromSeconds(seconds);
    if (!stamps.empty() && stamp > stamps.back()) ++risen;
    stamps.push_back(stamp);
  }
  // The image stage handles a late image and a clock that was set back. But a file without order is useless.
  if (stamps.size() > 1 && 2 * risen < stamps.size() - 1) {
    throw std::runtime_error(path + ": only " + std::to_string(risen) + " of " +
                             std::to_string(stamps.size()) +
                             " times lie after the one before; times must increase from image to image");
  }
  return stamps;
}

/// The numbers of a line `key: numbers`; none for any other line. @throws std::runtime_error if they are no matrix
std::optional<Projection> projectionIn(const TextLine& line, const std::string& key,
                                       const std::string& path) {
  const std::size_t colon = line.text.find(':');
  if (colon == std::string::npos || trimmed(line.text.substr(0, colon)) != key) return std::nullopt;
  const auto refuse = [&](const std::string& reason) {
    throw std::runtime_error(path + ":" + std::to_string(line.number) + ": " + key + ": " + reason +
                             "; it is the 12 numbers of a 3x4 matrix, with blanks between them");
  };
  std::istringstream words(line.text.substr(colon + 1));
  Projection projection{};
  std::string word;
  for (double& number : projection) {
    if (!(words >> word)) refuse("it ends too early");
    if (!parseNumber(word, number)) refuse("'" + shown(word) + "' is not a number");
  }
  if (words >> word) refuse("'" + shown(word) + "' is one too many");
  return projection;
}

Projection readProjection(const std::string& path, int camera_number) {
  const std::string number = std::to_string(camera_number);
  const auto lines = readLines(path);
  for (const std::string& key : {"P" + number, "P_rect_0" + number}) {
    std::optional<Projection> found;
    for (const TextLine& line : lines) {
      const auto projection = projectionIn(line, key, path);
      if (found && projection && *found != *projection) {
        throw std::runtime_error(path + ":" + std::to_string(line.number) + ": " + key + " is given twice");
      }
      if (projection) found = projection;
    }
    if (found) return *found;
  }
  throw std::runtime_error(path + ": no line 'P" + number + ":' with the 12 numbers of a 3x4 matrix");
}

/// Number of a KITTI camera: the last digit of the folder's name, which a shell may have completed by a slash; 0 if there
/// is none.
int cameraNumber(const std::string& image_folder) {
  const std::size_t end = image_folder.find_last_not_of('/');
  const char last = end == std::string::npos ? '0' : image_folder[end];
  return last >= '0' && last <= '9' ? last - '0' : 0;
}

}  // namespace

KittiFolder::KittiFolder(const std::string& folder, const std::string& image_folder,
                         const ImageLimits& limits)
    : folder_(folder),
      camera_number_(cameraNumber(image_folder)),
      images_(listImages(image_folder == "." ? folder : folder + "/" + image_folder)),
      limits_(limits) {
  const std::string times_path = folder + "/times.txt";
  const std::vector<Stamp> times = readTimes(times_path);
  if (times.size() > images_.size()) {
    remarks_.push_back(times_path + ": " + std::to_string(times.size()) + " times for " +
                       std::to_string(images_.size()) +
                       " images: each image takes the time of the number in its name");
  }
  for (const std::size_t row : timesOf(images_, times.size(), times_path)) stamps_.push_back(times[row]);
}

cv::Size KittiFolder::imageSize() const {
  for (const std::string& path : images_) {
    try {
      return measureImageFile(path);
    } catch (const BadImage&) {  // is reported when the image is read
    }
  }
  throw std::runtime_error(images_.front() + ": neither this nor any other image can be read");
}

std::optional<CameraModel> KittiFolder::camera() const {
  const std::string path = folder_ + "/calib.txt";
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Projection p = readProjection(path, camera_number_);
  const cv::Size size = imageSize();
  CameraModel camera{size.width, size.height, p[0], p[5], p[2], p[6], LensModel::kNone, {}};
  try {
    camera.validate();
    requireNoSkew("row 1, column 2", p[1], camera);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(path + ": P" + std::to_string(camera_number_) + ": " + error.what());
  }
  return camera;
}

std::optional<RecordedItem> KittiFolder::next() {
  if (next_ >= images_.size()) return std::nullopt;
  RecordedImage image;
  image.stamp = stamps_[next_];
  image.name = images_[next_];
  image.decode = [path = image.name, limits = limits_] { return decodeImageFile(path, limits); };
  ++next_;
  return image;
}

}  // namespace ratslam
