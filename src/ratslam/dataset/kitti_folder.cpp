#include "ratslam/dataset/kitti_folder.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "ratslam/dataset/csv.h"

namespace ratslam {
namespace {

std::vector<Stamp> readTimes(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot open the images' times");
  std::vector<Stamp> stamps;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    double seconds = 0.0;
    if (!parseNumber(line, seconds)) {
      throw std::runtime_error(path + ":" + std::to_string(number) + ": '" + line +
                               "' is not a time in seconds");
    }
    stamps.push_back(stampFromSeconds(seconds));
  }
  return stamps;
}

std::optional<std::array<double, 12>> readProjection(const std::string& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::string name;
  std::array<double, 12> projection{};
  file >> name;
  for (double& number : projection) file >> number;
  if (!file || name != "P0:")
    throw std::runtime_error(path + ":1: expected 'P0:' and the 12 numbers of a 3x4 matrix");
  return projection;
}

}  // namespace

KittiFolder::KittiFolder(const std::string& folder, const ImageLimits& limits)
    : images_(listImages(folder + "/image_0")),
      stamps_(readTimes(folder + "/times.txt")),
      projection_(readProjection(folder + "/calib.txt")),
      limits_(limits) {
  if (stamps_.size() < images_.size()) {
    throw std::runtime_error(folder + "/times.txt: has " + std::to_string(stamps_.size()) + " times for " +
                             std::to_string(images_.size()) + " images");
  }
}

cv::Size KittiFolder::imageSize() const {
  for (const std::string& path : images_) {
    try {
      return measureImageFile(path);
    } catch (const BadImage&) {  // it is told when its turn comes
    }
  }
  throw std::runtime_error(images_.front() + ": neither this nor any other image can be read");
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
