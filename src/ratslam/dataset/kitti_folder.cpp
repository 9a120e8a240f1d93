#include "ratslam/dataset/kitti_folder.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>

namespace ratslam {
namespace {

namespace fs = std::filesystem;

bool parseNumber(const std::string& text, double& number) {
  char* end = nullptr;
  number = std::strtod(text.c_str(), &end);
  while (*end == ' ' || *end == '\r' || *end == '\t') ++end;
  return end != text.c_str() && *end == '\0' && std::isfinite(number);
}

std::vector<std::string> listImages(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + ": no such folder of images");
  std::vector<std::string> images;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".png" || ending == ".jpg" || ending == ".jpeg") images.push_back(entry.path().string());
  }
  std::sort(images.begin(), images.end());
  if (images.empty()) throw std::runtime_error(folder.string() + ": has no .png or .jpg images");
  return images;
}

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

std::vector<std::string> splitCsv(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream stream(line);
  for (std::string word; std::getline(stream, word, ',');) {
    while (!word.empty() && (word.back() == '\r' || word.back() == ' ')) word.pop_back();
    words.push_back(word);
  }
  return words;
}

}  // namespace

KittiFolder::KittiFolder(const std::string& folder)
    : images_(listImages(fs::path(folder) / "image_0")),
      stamps_(readTimes(folder + "/times.txt")),
      projection_(readProjection(folder + "/calib.txt")) {
  if (stamps_.size() < images_.size()) {
    throw std::runtime_error(folder + "/times.txt: has " + std::to_string(stamps_.size()) + " times for " +
                             std::to_string(images_.size()) + " images");
  }
}

std::optional<RecordedItem> KittiFolder::next() {
  if (next_ >= images_.size()) return std::nullopt;
  RecordedImage image;
  image.stamp = stamps_[next_];
  image.name = images_[next_];
  image.decode = [path = image.name] { return cv::imread(path, cv::IMREAD_UNCHANGED); };
  ++next_;
  return image;
}

std::vector<OdometrySample> readOdometryCsv(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot open this odometry file");
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> names = splitCsv(line);
  const auto columnOf = [&](const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) throw std::runtime_error(path + ":1: has no column named " + name);
    return static_cast<std::size_t>(found - names.begin());
  };
  const std::array<std::size_t, 3> columns{columnOf("stamp"), columnOf("linear_x"), columnOf("angular_z")};
  std::vector<OdometrySample> samples;
  for (int number = 2; std::getline(file, line); ++number) {
    const std::vector<std::string> words = splitCsv(line);
    if (words.empty()) continue;
    std::array<double, 3> values{};
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i] >= words.size() || !parseNumber(words[columns[i]], values[i])) {
        throw std::runtime_error(path + ":" + std::to_string(number) + ": column " + names[columns[i]] +
                                 " is missing or not a finite number");
      }
    }
    OdometrySample sample;
    sample.stamp = stampFromSeconds(values[0]);
    sample.speed = values[1];
    sample.yaw_rate = values[2];
    if (!samples.empty() && sample.stamp <= samples.back().stamp) {
      throw std::runtime_error(path + ":" + std::to_string(number) + ": stamps must rise from line to line");
    }
    samples.push_back(sample);
  }
  return samples;
}

std::optional<RecordedItem> RecordingWithOdometry::next() {
  while (!waiting_image_) {
    waiting_image_ = images_.next();
    if (!waiting_image_) break;
    if (std::holds_alternative<OdometrySample>(*waiting_image_)) waiting_image_.reset();
  }
  const bool odometry_left = next_odometry_ < odometry_.size();
  if (odometry_left && (!waiting_image_ ||
                        odometry_[next_odometry_].stamp <= std::get<RecordedImage>(*waiting_image_).stamp)) {
    return odometry_[next_odometry_++];
  }
  std::optional<RecordedItem> image;
  image.swap(waiting_image_);
  return image;
}

}  // namespace ratslam
