#include "ratslam/dataset/odometry_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "ratslam/common/atomic_file.h"
#include "ratslam/common/text_file.h"
#include "ratslam/dataset/csv.h"
#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/odometry/possible.h"

namespace ratslam {
namespace {

const std::vector<std::string> kPoseColumns{"r11", "r12", "r13", "x",   "r21", "r22",
                                            "r23", "y",   "r31", "r32", "r33", "z"};
const std::vector<std::string> kQualityColumns{"unit_anchor", "unit_walk", "epoch", "bridged"};
const char* const kConstantColumn = "unit_constant";
const std::vector<std::string> kCorrectionColumns{"correction_from", "correction_to", "correction_way"};

std::vector<std::string> prefixed(const std::string& prefix, const std::vector<std::string>& names) {
  std::vector<std::string> result;
  for (const std::string& name : names) result.push_back(prefix + name);
  return result;
}

/// Names of columns prefix11 ... prefix66, row by row.
std::vector<std::string> covarianceColumns(const std::string& prefix) {
  std::vector<std::string> names;
  for (int i = 0; i < 36; ++i)
    names.push_back(prefix + std::to_string(i / 6 + 1) + std::to_string(i % 6 + 1));
  return names;
}

constexpr Stamp kLatestStamp = (Stamp{1} << 32) * 1000000000 - 1;  // largest ROS stamp

/// Access to the lines of a CSV file by the names in its first line.
class Columns {
 public:
  Columns(const std::string& path, const std::string& first_line)
      : path_(path), names_(splitCsv(first_line)) {}

  void requireDistinct() const {
    for (auto name = names_.begin(); name != names_.end(); ++name) {
      if (!name->empty() && std::find(names_.begin(), name, *name) != name) {
        throw std::runtime_error(path_ + ":1: names the column " + shown(*name) + " twice");
      }
    }
  }
  bool has(const std::string& name) const {
    return std::find(names_.begin(), names_.end(), name) != names_.end();
  }
  /// Indices of columns; empty if there is none of them. @throws if only some of them exist
  std::vector<std::size_t> find(const std::vector<std::string>& names) const {
    std::vector<std::size_t> found;
    // A file of others may have an x and a y of its own.
    const bool any = std::any_of(names.begin(), names.end(),
                                 [this](const std::string& name) { return name.size() > 1 && has(name); });
    if (!any) return found;
    for (const std::string& name : names) {
      const auto column = std::find(names_.begin(), names_.end(), name);
      if (column == names_.end()) throw std::runtime_error(path_ + ":1: has no column named " + name);
      found.push_back(static_cast<std::size_t>(column - names_.begin()));
    }
    return found;
  }
  void setLine(const TextLine& line) {
    number_ = line.number;
    words_ = splitCsv(line.text);
    if (words_.size() <= names_.size()) return;
    const bool commas = line.text.find('.') == std::string::npos;
    fail(std::to_string(words_.size()) + " values under " + std::to_string(names_.size()) + " columns" +
         (commas ? "; if decimals are written with commas, write them with points" : ""));
  }

  /// Whether a column of this line is not empty.
  bool said(std::size_t column) const { return !word(column).empty(); }
  double number(std::size_t column) const {
    double value = 0.0;
    if (!parseNumber(word(column), value)) complain(column, "a finite number");
    return value;
  }
  /// A number that may be inf or nan: covariances of that kind are replaced, and counted, by whoever uses the sample.
  double anyNumber(std::size_t column) const {
    const std::string text = word(column);
    char* end = nullptr;
    const double value = toNumber(text.c_str(), &end);
    if (text.empty() || *end != '\0') complain(column, "a number");
    return value;
  }
  std::uint32_t count(std::size_t column) const {
    const double value = number(column);
    if (value < 0.0 || value > 4294967295.0 || value != std::floor(value)) {
      complain(column, "a whole number, 0 to 2^32 - 1");
    }
    return static_cast<std::uint32_t>(value);
  }
  Stamp stamp(std::size_t column) const {
    const std::optional<Stamp> stamp = parseStamp(word(column));
    if (!stamp || *stamp < 0 || *stamp > kLatestStamp) complain(column, "a time in seconds, 0 to 2^32");
    return *stamp;
  }
  const std::string& path() const { return path_; }
  std::string word(std::size_t column) const { return column < words_.size() ? words_[column] : ""; }
  [[noreturn]] void fail(const std::string& reason) const {
    throw std::runtime_error(path_ + ":" + std::to_string(number_) + ": " + reason);
  }

 private:
  [[noreturn]] void complain(std::size_t column, const std::string& wanted) const {
    fail("column " + names_[column] + ": '" + shown(word(column)) + "' is not " + wanted);
  }

  std::string path_;
  std::vector<std::string> names_;
  std::vector<std::string> words_;
  int number_ = 1;
};

Eigen::Isometry3d readPose(const Columns& columns, const std::vector<std::size_t>& at) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < at.size(); ++i) {
    pose.matrix()(static_cast<int>(i) / 4, static_cast<int>(i) % 4) = columns.number(at[i]);
  }
  constexpr double kTolerance = 1e-2;
  const Eigen::Matrix3d turn = pose.linear();
  if (!(turn.transpose() * turn).isApprox(Eigen::Matrix3d::Identity(), kTolerance) ||
      turn.determinant() < 0.0) {
    columns.fail("r11 to r33 are no rotation matrix");
  }
  return pose;
}

TwistCovariance readCovariance(const Columns& columns, const std::vector<std::size_t>& at) {
  TwistCovariance covariance = TwistCovariance::Zero();
  for (std::size_t i = 0; i < at.size(); ++i)
    covariance(static_cast<int>(i) / 6, static_cast<int>(i) % 6) = columns.anyNumber(at[i]);
  return covariance;
}

/// Stamps and poses of 12 numbers each, with blanks between the numbers and a semicolon after each pose.
std::vector<StampedMotion> readWay(const Columns& columns, std::size_t column) {
  std::vector<StampedMotion> way;
  std::istringstream poses(columns.word(column));
  for (std::string text; std::getline(poses, text, ';');) {
    std::istringstream words(text);
    std::string stamp;
    words >> stamp;
    StampedMotion moved;
    const std::optional<Stamp> parsed = parseStamp(stamp);
    for (int i = 0; i < 12; ++i) words >> moved.motion.matrix()(i / 4, i % 4);
    if (!parsed || !words || !moved.motion.matrix().allFinite()) {
      columns.fail("correction_way: each pose is a stamp and the 12 numbers of [R|t]");
    }
    moved.stamp = *parsed;
    way.push_back(moved);
  }
  return way;
}

/// Columns of the parts of a sample.
struct SampleColumns {
  explicit SampleColumns(const Columns& columns)
      : required(columns.find({"stamp", "linear_x", "angular_z"})),
        sideways(columns.find({"linear_y"})),
        pose(columns.find(kPoseColumns)),
        covariance(columns.find(covarianceColumns("cov_"))),
        quality(columns.find(kQualityColumns)),
        unit_constant(columns.find({kConstantColumn})),
        correction(columns.find(kCorrectionColumns)),
        correction_motion(columns.find(prefixed("correction_", kPoseColumns))),
        correction_covariance(columns.find(covarianceColumns("correction_cov_"))) {
    if (!correction.empty() && (correction_motion.empty() || correction_covariance.empty())) {
      throw std::runtime_error(columns.path() + ":1: has no column named " +
                               (correction_motion.empty() ? "correction_r11" : "correction_cov_11"));
    }
  }

  OdometrySample read(const Columns& columns) const {
    OdometrySample sample;
    sample.stamp = columns.stamp(required[0]);
    sample.speed = columns.number(required[1]);
    sample.yaw_rate = columns.number(required[2]);
    if (!sideways.empty() && columns.said(sideways[0])) sample.sideways = columns.number(sideways[0]);
    if (!pose.empty()) sample.pose = readPose(columns, pose);
    if (!covariance.empty() && columns.said(covariance[0])) {
      sample.covariance = readCovariance(columns, covariance);
    }
    if (!quality.empty()) readQuality(columns, sample);
    if (!correction.empty() && columns.said(correction[0])) {
      OdometryCorrection known;
      known.from = columns.stamp(correction[0]);
      known.to = columns.stamp(correction[1]);
      known.motion = readPose(columns, correction_motion);
      known.covariance = readCovariance(columns, correction_covariance);
      known.way = readWay(columns, correction[2]);
      sample.correction = known;
    }
    return sample;
  }

  void readQuality(const Columns& columns, OdometrySample& sample) const {
    if (columns.said(quality[1])) {
      sample.unit.emplace();
      if (columns.said(quality[0])) sample.unit->anchor_sigma = columns.number(quality[0]);
      sample.unit->walk_sigma = columns.number(quality[1]);
      if (!unit_constant.empty() && columns.said(unit_constant[0])) {
        sample.unit->constant_sigma = columns.number(unit_constant[0]);
      }
    }
    if (columns.said(quality[2])) sample.epoch = columns.count(quality[2]);
    if (columns.said(quality[3])) sample.bridged = columns.count(quality[3]) != 0;
  }

  std::vector<std::size_t> required;
  std::vector<std::size_t> sideways;
  std::vector<std::size_t> pose;
  std::vector<std::size_t> covariance;
  std::vector<std::size_t> quality;
  std::vector<std::size_t> unit_constant;  ///< files of earlier versions have none
  std::vector<std::size_t> correction;
  std::vector<std::size_t> correction_motion;
  std::vector<std::size_t> correction_covariance;
};

/// The parts that a file of samples must have.
struct SampleParts {
  explicit SampleParts(const std::vector<OdometrySample>& samples) {
    for (const OdometrySample& sample : samples) {
      sideways = sideways || sample.sideways != 0.0;
      pose = pose && sample.pose;
      covariance = covariance || sample.covariance;
      quality = quality || sample.unit || sample.epoch != 0 || sample.bridged;
      correction = correction || sample.correction;
    }
  }
  bool sideways = false;
  bool pose = true;
  bool covariance = false;
  bool quality = false;
  bool correction = false;
};

void writeNames(std::ostream& out, const std::vector<std::string>& names) {
  for (const std::string& name : names) out << ',' << name;
}

/// Writes the first rows of a matrix, or as many empty columns if it is null.
template <class Matrix>
void writeRows(std::ostream& out, const Matrix* matrix, int rows) {
  for (int i = 0; i < rows * Matrix::ColsAtCompileTime; ++i) {
    out << ',';
    if (matrix != nullptr) out << (*matrix)(i / Matrix::ColsAtCompileTime, i % Matrix::ColsAtCompileTime);
  }
}

void writeQuality(std::ostream& out, const OdometrySample& sample) {
  out << ',';
  if (sample.unit && sample.unit->anchor_sigma) out << *sample.unit->anchor_sigma;
  out << ',';
  if (sample.unit) out << sample.unit->walk_sigma;
  out << ',' << sample.epoch << ',' << (sample.bridged ? 1 : 0) << ',';
  if (sample.unit) out << sample.unit->constant_sigma;
}

void writeCorrection(std::ostream& out, const std::optional<OdometryCorrection>& correction) {
  if (correction) {
    out << ',' << formatStamp(correction->from) << ',' << formatStamp(correction->to) << ',';
    for (const StampedMotion& moved : correction->way) {
      out << formatStamp(moved.stamp);
      for (int i = 0; i < 12; ++i) out << ' ' << moved.motion.matrix()(i / 4, i % 4);
      out << ';';
    }
  } else {
    out << ",,,";
  }
  writeRows(out, correction ? &correction->motion.matrix() : nullptr, 3);
  writeRows(out, correction ? &correction->covariance : nullptr, 6);
}

}  // namespace

std::vector<OdometrySample> readOdometryCsv(const std::string& path) {
  const std::vector<TextLine> lines = readLines(path);
  if (lines.empty()) throw std::runtime_error(path + ": is empty; its first line must name its columns");
  Columns columns(path, lines.front().text);
  const std::string hint =
      "; columns are parted by commas, and this line is '" + shown(lines.front().text) + "'";
  for (const char* name : {"stamp", "linear_x", "angular_z"}) {
    if (!columns.has(name)) columns.fail(std::string("has no column named ") + name + hint);
  }
  columns.requireDistinct();
  const SampleColumns parts(columns);
  std::vector<OdometrySample> samples;
  for (auto line = std::next(lines.begin()); line != lines.end(); ++line) {
    columns.setLine(*line);
    const OdometrySample sample = parts.read(columns);
    const std::string impossible = whyImpossible(sample);
    if (!impossible.empty()) columns.fail(impossible);
    if (!samples.empty() && sample.stamp <= samples.back().stamp) {
      columns.fail("stamps must rise from line to line");
    }
    samples.push_back(sample);
  }
  if (samples.empty()) throw std::runtime_error(path + ": names columns, but holds no odometry");
  return samples;
}

void writeOdometryCsv(const std::string& path, const std::vector<OdometrySample>& samples) {
  AtomicFile file(path);
  writeOdometryCsv(file.stream(), samples);
  file.commit();
}

void writeOdometryCsv(std::ostream& file, const std::vector<OdometrySample>& samples) {
  const SampleParts parts(samples);
  const auto precision = file.precision(std::numeric_limits<double>::max_digits10);
  file << "frame,stamp,linear_x,angular_z";
  if (parts.sideways) file << ",linear_y";
  if (parts.pose) writeNames(file, kPoseColumns);
  if (parts.covariance) writeNames(file, covarianceColumns("cov_"));
  if (parts.quality) {
    writeNames(file, kQualityColumns);
    writeNames(file, {kConstantColumn});
  }
  if (parts.correction) {
    writeNames(file, kCorrectionColumns);
    writeNames(file, prefixed("correction_", kPoseColumns));
    writeNames(file, covarianceColumns("correction_cov_"));
  }
  file << '\n';
  for (std::size_t frame = 0; frame < samples.size(); ++frame) {
    const OdometrySample& sample = samples[frame];
    file << frame << ',' << formatStamp(sample.stamp) << ',' << sample.speed << ',' << sample.yaw_rate;
    if (parts.sideways) file << ',' << sample.sideways;
    if (parts.pose) writeRows(file, &sample.pose->matrix(), 3);
    if (parts.covariance) writeRows(file, sample.covariance ? &*sample.covariance : nullptr, 6);
    if (parts.quality) writeQuality(file, sample);
    if (parts.correction) writeCorrection(file, sample.correction);
    file << '\n';
  }
  file.precision(precision);
}

void RecordingWithOdometry::fetchImages() {
  const auto fetch = [this]() -> std::optional<RecordedImage> {
    while (auto item = images_->next()) {
      if (auto* image = std::get_if<RecordedImage>(&*item)) return std::move(*image);
    }
    return std::nullopt;
  };
  if (!waiting_image_ && failure_) std::rethrow_exception(failure_);
  if (!waiting_image_) waiting_image_ = image_after_ ? std::exchange(image_after_, std::nullopt) : fetch();
  if (!waiting_image_ || image_after_ || failure_) return;
  try {
    image_after_ = fetch();
  } catch (...) {
    failure_ = std::current_exception();
  }
}

/// Odometry is handed out up to the waiting image's stamp. If the next image shows that this stamp is too high, only up
/// to the next image's stamp; otherwise later images would be late.
Stamp RecordingWithOdometry::stampForOdometry() const {
  const Stamp stamp = waiting_image_->stamp;
  if (!image_after_ || image_after_->stamp >= stamp) return stamp;
  const bool goes_on = !last_image_ || image_after_->stamp > *last_image_;
  return goes_on ? image_after_->stamp : stamp;
}

std::optional<RecordedItem> RecordingWithOdometry::next() {
  fetchImages();
  const bool odometry_left = next_odometry_ < odometry_.size();
  if (odometry_left && (!waiting_image_ || odometry_[next_odometry_].stamp <= stampForOdometry())) {
    return odometry_[next_odometry_++];
  }
  if (!waiting_image_) return std::nullopt;
  last_image_ = waiting_image_->stamp;
  return RecordedItem(*std::exchange(waiting_image_, std::nullopt));
}

}  // namespace ratslam
