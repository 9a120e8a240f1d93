#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>

#include "ratslam/common/params.h"
#include "ratslam/dataset/odometry_file.h"
#include "town/town_sink.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

void makeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throwBadValue("out", folder.string(), "the folder cannot be made: " + error.message());
}

/// A text file that reports when it cannot be written.
class TextFile {
 public:
  explicit TextFile(const fs::path& path) : path_(path), out_(path) { check(); }
  template <class T>
  TextFile& operator<<(const T& value) {
    out_ << value;
    return *this;
  }
  void close() {
    out_.close();
    check();
  }

 private:
  void check() const {
    if (!out_) throw std::runtime_error(path_.string() + ": cannot be written");
  }
  fs::path path_;
  std::ofstream out_;
};

std::string digits(double value, int precision) {
  std::ostringstream out;
  out << std::setprecision(precision) << value;
  return out.str();
}

std::string fixed(double value, int decimals) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(decimals) << value;
  return out.str();
}

/// Accuracy of a fix by Android's definition: the radius that contains 68 % of a round Gaussian. 0 would mean unknown.
double statedAccuracy(double sigma) { return std::max(1.5096 * sigma, 0.01); }

void writeImage(const fs::path& path, const cv::Mat& image, int jpeg_quality) {
  // PNG's strongest compression takes longer than drawing the picture and saves little.
  const std::vector<int> flags = jpeg_quality > 0 ? std::vector<int>{cv::IMWRITE_JPEG_QUALITY, jpeg_quality}
                                                  : std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 1};
  if (!cv::imwrite(path.string(), image, flags))
    throw std::runtime_error(path.string() + ": cannot be written");
}

class KittiSink : public TownSink {
 public:
  explicit KittiSink(const TownOptions& options) : options_(options), folder_(options.out) {
    for (const char* name : {"image_0", "times.txt", "calib.txt", "poses.txt", "odometry.csv"})
      expectAbsent(folder_ / name);
  }

  void add(const TownFrame& frame) override {
    if (!poses_) open();
    std::ostringstream name;
    name << std::setw(6) << std::setfill('0') << frame.index << (options_.jpeg_quality > 0 ? ".jpg" : ".png");
    writeImage(folder_ / "image_0" / name.str(), frame.image, options_.jpeg_quality);
    *times_ << digits(toSeconds(frame.stamp), 12) << "\n";
    const Eigen::Matrix4d pose = frame.T_world_camera.matrix();
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        *poses_ << digits(pose(row, column), 12) << (row == 2 && column == 3 ? "\n" : " ");
    if (frame.wheel) wheel_.push_back(*frame.wheel);
  }

  void finish() override {
    for (TextFile* file : {poses_.get(), times_.get()})
      if (file != nullptr) file->close();
    if (!wheel_.empty()) writeOdometryCsv((folder_ / "odometry.csv").string(), wheel_);
  }

 private:
  void open() {
    makeFolder(folder_ / "image_0");
    poses_ = std::make_unique<TextFile>(folder_ / "poses.txt");
    times_ = std::make_unique<TextFile>(folder_ / "times.txt");
    const TownCamera camera = options_.camera();
    TextFile calibration(folder_ / "calib.txt");
    for (int i = 0; i < 4; ++i) {
      calibration << "P" << i << ":";
      for (const double value :
           {camera.fx, 0.0, camera.cx, 0.0, 0.0, camera.fy, camera.cy, 0.0, 0.0, 0.0, 1.0, 0.0})
        calibration << " " << digits(value, 13);
      calibration << "\n";
    }
    calibration.close();
  }

  TownOptions options_;
  fs::path folder_;
  std::unique_ptr<TextFile> poses_, times_;
  std::vector<OdometrySample> wheel_;
};

class RecorderSink : public TownSink {
 public:
  explicit RecorderSink(const TownOptions& options)
      : options_(options),
        start_(stampFromSeconds(options.start)),
        jpeg_quality_(options.jpeg_quality > 0 ? options.jpeg_quality : kDefaultQuality) {
    const auto seconds = static_cast<std::time_t>(options.start);
    std::tm utc{};
    gmtime_r(&seconds, &utc);
    std::ostringstream name;
    name << std::put_time(&utc, "%y-%m-%d-%H-%M-%S");
    folder_ = fs::path(options.out) / name.str();
    for (const fs::path& path :
         {folder_, fs::path(options.out) / "truth.tum", fs::path(options.out) / "calibration.yaml"})
      expectAbsent(path);
  }

  void add(const TownFrame& frame) override {
    if (!images_) open();
    const std::string ms = milliseconds(frame.stamp);
    writeImage(folder_ / "images" / (ms + ".jpeg"), frame.image, jpeg_quality_);
    *images_ << ms << ",images/" << ms << ".jpeg\n";
    for (const ImuSample& sample : frame.imu) {
      *imu_ << milliseconds(sample.stamp);
      for (int i = 0; i < 3; ++i) *imu_ << "," << fixed(sample.acceleration[i], 6);
      for (int i = 0; i < 3; ++i) *imu_ << "," << fixed(sample.angular_rate[i], 6);
      *imu_ << "\n";
    }
    if (frame.gps)
      *gps_ << ms << "," << fixed(frame.gps->latitude, 9) << "," << fixed(frame.gps->longitude, 9) << ","
            << fixed(frame.gps->altitude, 3) << "," << fixed(statedAccuracy(frame.gps->accuracy), 2) << ","
            << fixed(frame.gps->bearing, 2) << "," << fixed(frame.gps->speed, 3) << ",gps\n";
    // The images' stamps are whole milliseconds, and so are the truth's: they are the same.
    const Eigen::Quaterniond q(frame.T_world_camera.linear());
    *truth_ << ms.substr(0, ms.size() - 3) << "." << ms.substr(ms.size() - 3);
    for (int i = 0; i < 3; ++i) *truth_ << " " << digits(frame.T_world_camera.translation()[i], 12);
    for (const double value : {q.x(), q.y(), q.z(), q.w()}) *truth_ << " " << digits(value, 12);
    *truth_ << "\n";
  }

  void finish() override {
    for (TextFile* file : {images_.get(), imu_.get(), gps_.get(), truth_.get()})
      if (file != nullptr) file->close();
  }

 private:
  static constexpr int kDefaultQuality = 90;

  std::string milliseconds(Stamp stamp) const { return std::to_string((start_ + stamp + 500000) / 1000000); }

  void open() {
    makeFolder(folder_ / "images");
    images_ = std::make_unique<TextFile>(folder_ / "data_image.txt");
    imu_ = std::make_unique<TextFile>(folder_ / "data_imu.txt");
    gps_ = std::make_unique<TextFile>(folder_ / "data_gps.txt");
    truth_ = std::make_unique<TextFile>(fs::path(options_.out) / "truth.tum");
    const TownCamera camera = options_.camera();
    TextFile calibration(fs::path(options_.out) / "calibration.yaml");
    calibration << "image_width: " << camera.width << "\nimage_height: " << camera.height << "\n";
    constexpr std::array<const char*, 9> kKeys{"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
    std::vector<double> values{camera.fx, camera.fy, camera.cx, camera.cy};
    values.insert(values.end(), camera.distortion.begin(), camera.distortion.end());
    for (std::size_t i = 0; i < kKeys.size(); ++i)
      calibration << kKeys[i] << ": " << digits(values[i], 13) << "\n";
    calibration.close();
  }

  TownOptions options_;
  fs::path folder_;
  Stamp start_;
  int jpeg_quality_;
  std::unique_ptr<TextFile> images_, imu_, gps_, truth_;
};

}  // namespace

void expectAbsent(const std::string& path) {
  std::error_code error;
  // A link that leads nowhere is there as well: a file would be written through it.
  if (fs::exists(fs::symlink_status(path, error)))
    throwBadValue("out", path, "it exists already; choose another --out, or remove it");
}

std::unique_ptr<TownSink> makeFolderSink(const TownOptions& options) {
  options.validate();
  options.expectEffects();
  if (options.layout == "recorder") return std::make_unique<RecorderSink>(options);
  return std::make_unique<KittiSink>(options);
}

}  // namespace ratslam
