#include "ratslam/dataset/odometry_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "ratslam/common/atomic_file.h"
#include "ratslam/dataset/csv.h"
#include "ratslam/dataset/trajectory_io.h"

namespace ratslam {
namespace {

constexpr std::array<const char*, 12> kPoseColumns{"r11", "r12", "r13", "x",   "r21", "r22",
                                                   "r23", "y",   "r31", "r32", "r33", "z"};

/// A line of a CSV file, looked into by the names of its first line.
class Columns {
 public:
  Columns(const std::string& path, const std::string& first_line)
      : path_(path), names_(splitCsv(first_line)) {}

  bool has(const std::string& name) const {
    return std::find(names_.begin(), names_.end(), name) != names_.end();
  }
  void setLine(int number, const std::string& line) {
    number_ = number;
    words_ = splitCsv(line);
  }
  bool empty() const { return words_.empty(); }

  double number(const std::string& name) const {
    double value = 0.0;
    if (!parseNumber(word(name), value)) complain(name);
    return value;
  }
  Stamp stamp() const {
    const std::optional<Stamp> stamp = parseStamp(word("stamp"));
    if (!stamp) complain("stamp");
    return *stamp;
  }
  [[noreturn]] void fail(const std::string& reason) const {
    throw std::runtime_error(path_ + ":" + std::to_string(number_) + ": " + reason);
  }

 private:
  std::string word(const std::string& name) const {
    const auto index =
        static_cast<std::size_t>(std::find(names_.begin(), names_.end(), name) - names_.begin());
    if (index == names_.size()) throw std::runtime_error(path_ + ":1: has no column named " + name);
    return index < words_.size() ? words_[index] : "";
  }
  [[noreturn]] void complain(const std::string& name) const {
    fail("column " + name + " is missing or not a finite number");
  }

  std::string path_;
  std::vector<std::string> names_;
  std::vector<std::string> words_;
  int number_ = 1;
};

Eigen::Isometry3d readPose(const Columns& columns) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < kPoseColumns.size(); ++i) {
    pose.matrix()(static_cast<int>(i) / 4, static_cast<int>(i) % 4) = columns.number(kPoseColumns[i]);
  }
  return pose;
}

}  // namespace

std::vector<OdometrySample> readOdometryCsv(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot open this odometry file");
  std::string line;
  std::getline(file, line);
  Columns columns(path, line);
  for (const char* name : {"stamp", "linear_x", "angular_z"}) {
    if (!columns.has(name)) columns.fail(std::string("has no column named ") + name);
  }
  const bool with_pose = columns.has(kPoseColumns.front());
  std::vector<OdometrySample> samples;
  for (int number = 2; std::getline(file, line); ++number) {
    columns.setLine(number, line);
    if (columns.empty()) continue;
    OdometrySample sample;
    sample.stamp = columns.stamp();
    sample.speed = columns.number("linear_x");
    sample.yaw_rate = columns.number("angular_z");
    if (with_pose) sample.pose = readPose(columns);
    if (!samples.empty() && sample.stamp <= samples.back().stamp) {
      columns.fail("stamps must rise from line to line");
    }
    samples.push_back(sample);
  }
  return samples;
}

void writeOdometryCsv(const std::string& path, const std::vector<OdometrySample>& samples) {
  AtomicFile file(path);
  writeOdometryCsv(file.stream(), samples);
  file.commit();
}

void writeOdometryCsv(std::ostream& file, const std::vector<OdometrySample>& samples) {
  const bool with_pose = std::all_of(samples.begin(), samples.end(),
                                     [](const OdometrySample& sample) { return sample.pose.has_value(); });
  const auto precision = file.precision(std::numeric_limits<double>::max_digits10);
  file << "frame,stamp,linear_x,angular_z";
  for (const char* name : kPoseColumns) {
    if (with_pose) file << ',' << name;
  }
  file << '\n';
  for (std::size_t frame = 0; frame < samples.size(); ++frame) {
    const OdometrySample& sample = samples[frame];
    file << frame << ',' << formatStamp(sample.stamp) << ',' << sample.speed << ',' << sample.yaw_rate;
    for (int i = 0; with_pose && i < 12; ++i) file << ',' << sample.pose->matrix()(i / 4, i % 4);
    file << '\n';
  }
  file.precision(precision);
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
