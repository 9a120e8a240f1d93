#include "ratslam/view/run_video.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <opencv2/core/utils/logger.hpp>
#include <sstream>
#include <stdexcept>

#include "ratslam/common/atomic_file.h"
#include "ratslam/view/composite.h"
#include "ratslam/view/draw_local_view.h"
#include "ratslam/view/draw_map.h"

namespace ratslam {
namespace {

int codecOf(const std::string& path) {
  const std::map<std::string, int> codecs{{".mp4", cv::VideoWriter::fourcc('m', 'p', '4', 'v')},
                                          {".avi", cv::VideoWriter::fourcc('M', 'J', 'P', 'G')}};
  const std::string ending = std::filesystem::path(path).extension().string();
  const auto found = codecs.find(ending);
  if (found == codecs.end()) {
    throw std::runtime_error(path + ": a video's name must end with .mp4 or .avi, not '" + ending + "'");
  }
  return found->second;
}

/// Suppresses OpenCV's messages about its attempts to open a video.
class Silence {
 public:
  Silence() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~Silence() { cv::utils::logging::setLogLevel(before_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

/// x.mp4 -> x.part.mp4: the ending must stay, because it selects the codec.
std::string partOf(const std::string& path) {
  std::filesystem::path part(path);
  const std::string ending = part.extension().string();
  return part.replace_extension(".part" + ending).string();
}

cv::VideoWriter openVideo(const std::string& path, const std::string& part, double frame_rate) {
  const int codec = codecOf(path);
  requireWritable(path);
  const Silence silence;
  cv::VideoWriter writer(part, codec, frame_rate, {kCompositeWidth, kCompositeHeight});
  if (!writer.isOpened()) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    std::ostringstream text;
    text << path << ": this OpenCV has no codec for such a video at camera_hz = " << frame_rate
         << " frames a second; try " << (std::filesystem::path(path).extension() == ".avi" ? ".mp4" : ".avi")
         << ", or another camera_hz";
    throw std::runtime_error(text.str());
  }
  return writer;
}

/// Number of frames that a player finds in a video.
std::size_t framesIn(const std::string& path) {
  const Silence silence;
  cv::VideoCapture video(path);
  if (!video.isOpened()) return 0;
  return static_cast<std::size_t>(std::max(0.0, video.get(cv::CAP_PROP_FRAME_COUNT)));
}

}  // namespace

void RunPicture::follow(const Pipeline::Progress& progress) {
  if (!progress.views.empty()) view_ = progress.views.back();
  for (const PoseCellDecision& decision : progress.decisions) trail_.add(decision.estimate);
}

cv::Mat RunPicture::draw(const Pipeline& pipeline, const cv::Mat& image) const {
  return composite(drawLocalView(image, view_, pipeline.localView(), localViewPictureSize()),
                   drawActivity(pipeline.poseCells().cells().activity(), trail_, activityPictureSize()),
                   drawMap(pipeline.map().graph(), pipeline.map().robotPose(), mapPictureSize()));
}

RunVideo::RunVideo(const std::string& path, double frame_rate)
    : path_(path), part_(partOf(path)), writer_(openVideo(path, part_, frame_rate)) {}

RunVideo::~RunVideo() {
  writer_.release();
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);  // finish() has renamed it already
}

void RunVideo::add(const Pipeline& pipeline, const cv::Mat& image) {
  writer_.write(picture_.draw(pipeline, image));
  ++frames_;
}

void RunVideo::finish() {
  writer_.release();
  const std::size_t found = framesIn(part_);
  if (found < frames_) {
    throw std::runtime_error(path_ + ": cannot write this video: " + std::to_string(found) + " of " +
                             std::to_string(frames_) + " pictures can be read back; is the disk full?");
  }
  std::error_code error;
  std::filesystem::rename(part_, path_, error);
  if (error) throw std::runtime_error(path_ + ": cannot write this video: " + error.message());
}

}  // namespace ratslam
