#include "ratslam/dataset/odometry_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <stdexcept>

#include "ratslam/dataset/csv.h"

namespace ratslam {

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
    waiting_image_ = images_->next();
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
