#include "ratslam/dataset/recorder_folder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <tuple>

#include "ratslam/common/params.h"
#include "ratslam/common/stamp.h"
#include "ratslam/common/text_file.h"
#include "ratslam/dataset/clock.h"
#include "ratslam/dataset/csv.h"
#include "ratslam/dataset/image_folder.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

/// Numbers with 16 digits are Unix microseconds, with up to 14 digits milliseconds, others nanoseconds.
std::optional<Stamp> stampOfName(const std::string& name) {
  constexpr Stamp kLatest = (Stamp{1} << 32) * 1000000000;  // bound of ROS stamps
  if (name.empty() || name.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
  const std::string latest = std::to_string(kLatest);
  if (name.size() > latest.size() || (name.size() == latest.size() && name >= latest)) return std::nullopt;
  const Stamp number = std::stoll(name);
  const Stamp unit = name.size() <= 14 ? 1000000 : name.size() == 16 ? 1000 : 1;
  if (number >= kLatest / unit) return std::nullopt;
  return number * unit;
}

bool leadsOutside(const std::string& path) {
  const fs::path relative(path);
  return relative.is_absolute() || std::find(relative.begin(), relative.end(), "..") != relative.end();
}

cv::Mat turned(const cv::Mat& image, int quarter_turns) {
  if (quarter_turns == 0 || image.empty()) return image;
  constexpr std::array<cv::RotateFlags, 3> kTurns = {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180,
                                                     cv::ROTATE_90_COUNTERCLOCKWISE};
  cv::Mat upright;
  cv::rotate(image, upright, kTurns[static_cast<std::size_t>(quarter_turns) - 1]);
  return upright;
}

}  // namespace

bool RecorderFolder::recognises(const std::string& folder) {
  std::error_code error;  // a link to itself is no recording
  return fs::exists(folder + "/data_image.txt", error) || fs::is_directory(folder + "/images", error);
}

RecorderFolder::RecorderFolder(const std::string& folder, int clockwise_deg, const ImageLimits& limits)
    : quarter_turns_(clockwise_deg / 90), limits_(limits) {
  if (clockwise_deg < 0 || clockwise_deg > 270 || clockwise_deg % 90 != 0) {
    throwBadValue("rotate", clockwise_deg, "it must be 0, 90, 180 or 270 degrees");
  }
  const std::string index_path = folder + "/data_image.txt";
  if (fs::exists(index_path)) {
    readIndex(folder, index_path);
  } else {
    readNames(folder);
  }
  sortByStamp();
  if (images_.empty()) {
    throw std::runtime_error(malformed_.empty() ? index_path + ": lists no images" : malformed_);
  }
}

void RecorderFolder::readIndex(const std::string& folder, const std::string& path) {
  constexpr std::size_t kLongestPath = 255;
  std::size_t malformed = 0;
  for (const TextLine& line : readLines(path)) {
    const std::string where = path + ":" + std::to_string(line.number) + ": ";
    const auto words = splitCsv(line.text);
    const auto stamp = words.empty() ? std::nullopt : stampOfName(words[0]);
    if (words.size() < 2 || !stamp ||
        words[1].size() > kLongestPath) {  // for example the last line of a recording that was cut off
      if (++malformed == 1) {
        malformed_ =
            where + "'" + shown(line.text) + "' is not of the form milliseconds,images/<milliseconds>.jpeg";
      }
      continue;
    }
    if (leadsOutside(words[1])) {
      throw std::runtime_error(where + "'" + shown(words[1]) +
                               "' does not lie within the recording's folder");
    }
    images_.emplace_back(*stamp, folder + "/" + words[1]);
  }
  if (malformed > 0)
    remarks_.push_back(malformed_ + " (" + std::to_string(malformed) + " such lines left out)");
  if (const auto jump = clockSetBack(images_)) {
    throw std::runtime_error(
        path + ": the phone's clock was set back by " + formatStamp(jump->back) + " s before the image of " +
        std::to_string(jump->first / 1000000) +
        " ms: the times before and after it overlap; keep the lines before it or those " +
        "from it on, and do each part alone");
  }
  const auto earlier = [](const StampedPath& a, const StampedPath& b) { return a.first < b.first; };
  if (!std::is_sorted(images_.begin(), images_.end(), earlier)) {
    remarks_.push_back(path + ": lines are out of order; images are taken by their times");
  }
}

void RecorderFolder::readNames(const std::string& folder) {
  const std::string inside = fs::is_directory(folder + "/images") ? folder + "/images" : folder;
  std::size_t nameless = 0;
  for (const std::string& path : listImages(inside)) {
    const auto stamp = stampOfName(fs::path(path).stem().string());
    if (stamp) {
      images_.emplace_back(*stamp, path);
    } else if (++nameless == 1) {
      malformed_ = path + ": without data_image.txt an image's name must be its time in ns, us or ms";
    }
  }
  if (nameless > 0)
    remarks_.push_back(malformed_ + " (" + std::to_string(nameless) + " such images left out)");
}

void RecorderFolder::sortByStamp() {
  const auto rank = [](const StampedPath& image) {
    std::error_code error;  // a file that cannot be accessed counts as missing
    return std::make_tuple(image.first, !fs::exists(image.second, error), image.second);
  };
  std::sort(images_.begin(), images_.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  const auto same = [](const StampedPath& a, const StampedPath& b) { return a.first == b.first; };
  const auto repeated = std::unique(images_.begin(), images_.end(), same);
  const auto count = std::distance(repeated, images_.end());
  images_.erase(repeated, images_.end());
  if (count > 0) remarks_.push_back(std::to_string(count) + " images with the time of another one left out");
  constexpr Stamp kTenDigits = 1'000'000'000'000'000;  // the least number of milliseconds with so many [ns]
  if (!images_.empty() && images_.front().first >= kTenDigits && images_.front().first < 10 * kTenDigits) {
    remarks_.push_back(images_.front().second +
                       ": time of 10 digits, taken as milliseconds (of 1970); is it in seconds?");
  }
}

std::optional<RecordedItem> RecorderFolder::next() {
  if (next_ >= images_.size()) return std::nullopt;
  RecordedImage image;
  image.stamp = images_[next_].first;
  image.name = images_[next_].second;
  image.decode = [path = image.name, turns = quarter_turns_, limits = limits_] {
    return turned(decodeImageFile(path, limits), turns);
  };
  ++next_;
  return image;
}

}  // namespace ratslam
