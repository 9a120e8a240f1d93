#include "ratslam/dataset/recorder_folder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <tuple>

#include "ratslam/common/params.h"
#include "ratslam/dataset/csv.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

/// Names of up to 13 digits are milliseconds, longer ones nanoseconds.
std::optional<Stamp> stampOfName(const std::string& name) {
  if (name.empty() || name.size() > 19 || name.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  const Stamp number = std::stoll(name);
  return name.size() <= 13 ? number * 1000000 : number;
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
  return fs::exists(folder + "/data_image.txt") || fs::is_directory(folder + "/images");
}

RecorderFolder::RecorderFolder(const std::string& folder, int clockwise_deg, const ImageLimits& limits)
    : quarter_turns_(clockwise_deg / 90), limits_(limits) {
  if (clockwise_deg < 0 || clockwise_deg > 270 || clockwise_deg % 90 != 0) {
    throwBadValue("rotate", clockwise_deg, "it must be 0, 90, 180 or 270 degrees");
  }
  const std::string index_path = folder + "/data_image.txt";
  std::string malformed;
  if (std::ifstream index(index_path); index) {
    std::string line;
    for (int number = 1; std::getline(index, line); ++number) {
      const auto words = splitCsv(line);
      if (words.empty()) continue;
      const auto stamp = stampOfName(words[0]);
      if (words.size() >= 2 && stamp) {
        images_.emplace_back(*stamp, folder + "/" + words[1]);
      } else if (malformed.empty()) {  // as a recording that was cut off ends
        malformed = index_path + ":" + std::to_string(number) + ": '" + line +
                    "' is not of the form milliseconds,images/<milliseconds>.jpeg";
      }
    }
  } else {
    for (const std::string& path : listImages(folder + "/images")) {
      const auto stamp = stampOfName(fs::path(path).stem().string());
      if (!stamp)
        throw std::runtime_error(path +
                                 ": without data_image.txt an image's name must be its time in ns or ms");
      images_.emplace_back(*stamp, path);
    }
  }
  const auto rank = [](const auto& image) {
    return std::make_tuple(image.first, !fs::exists(image.second), image.second);
  };
  std::sort(images_.begin(), images_.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
  images_.erase(std::unique(images_.begin(), images_.end(), same), images_.end());
  if (images_.empty()) {
    throw std::runtime_error(malformed.empty() ? index_path + ": lists no images" : malformed);
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
