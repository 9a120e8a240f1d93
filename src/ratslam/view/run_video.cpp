#include "ratslam/view/run_video.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/core/utils/logger.hpp>
#include <stdexcept>

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

cv::VideoWriter openVideo(const std::string& path, double frame_rate) {
  const int codec = codecOf(path);
  if (!std::ofstream(path)) throw std::runtime_error(path + ": cannot write this video");
  // OpenCV would tell the reason in many lines of its own, among them what it tried before it succeeded.
  const cv::utils::logging::LogLevel before =
      cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  cv::VideoWriter writer(path, codec, frame_rate, {kCompositeWidth, kCompositeHeight});
  cv::utils::logging::setLogLevel(before);
  if (!writer.isOpened()) {
    std::filesystem::remove(path);
    throw std::runtime_error(path + ": this OpenCV has no codec for such a video; try " +
                             (std::filesystem::path(path).extension() == ".avi" ? ".mp4" : ".avi"));
  }
  return writer;
}

}  // namespace

void RunPicture::follow(const Pipeline::Progress& progress) {
  if (!progress.views.empty()) view_ = progress.views.back();
  for (const PoseCellDecision& decision : progress.decisions) trail_.add(decision.estimate);
}

cv::Mat RunPicture::draw(const Pipeline& pipeline, const cv::Mat& image) const {
  const LocalViewCells& cells = pipeline.localView();
  return composite(
      drawLocalView(image, view_, cells.viewImage(), cells.templateImage(view_.id), localViewPictureSize()),
      drawActivity(pipeline.poseCells().cells().activity(), trail_, activityPictureSize()),
      drawMap(pipeline.map().graph(), pipeline.map().robotPose(), mapPictureSize()));
}

RunVideo::RunVideo(const std::string& path, double frame_rate) : writer_(openVideo(path, frame_rate)) {}

}  // namespace ratslam
