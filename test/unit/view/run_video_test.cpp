// What a run's video shows is looked at by people; what is tested is that it is there, whole, and told as it
// was.
#include "ratslam/view/run_video.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "ratslam/view/composite.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 5;

cv::Mat image(int frame) {
  cv::Mat grey(60, 120, CV_8UC1, cv::Scalar(40));
  cv::rectangle(grey, {20 * frame, 10, 15, 40}, cv::Scalar(220), cv::FILLED);
  return grey;
}

/// Drives a few metres; calls `see(pipeline, progress, image)` after each image.
template <class Visitor>
void drive(Visitor see) {
  PipelineParams params;
  params.local_view.view_template.x_size = 24;
  params.local_view.view_template.y_size = 6;
  params.local_view.shift_match = 2;
  params.local_view.step_match = 1;
  Pipeline pipeline(params, {});
  for (int frame = 0; frame < kFrames; ++frame) {
    OdometrySample sample;
    sample.stamp = frame * Stamp{100000000};
    sample.speed = 10.0;
    pipeline.addOdometry(sample);
    see(pipeline, pipeline.addImage({sample.stamp, image(frame)}), image(frame));
  }
}

std::vector<cv::Mat> framesOf(const fs::path& path) {
  cv::VideoCapture video(path.string());
  std::vector<cv::Mat> frames;
  for (cv::Mat frame; video.read(frame);) frames.push_back(frame.clone());
  return frames;
}

class VideoFile : public ::testing::TestWithParam<const char*> {};

TEST_P(VideoFile, HoldsThePictureOfEveryImage) {
  const fs::path path = fs::temp_directory_path() / ("run_video_test" + std::string(GetParam()));
  std::vector<cv::Mat> drawn;
  std::unique_ptr<RunVideo> video;
  try {
    video = std::make_unique<RunVideo>(path.string(), 10.0);
  } catch (const std::runtime_error& error) {
    GTEST_SKIP() << error.what();
  }
  RunPicture picture;
  drive([&](const Pipeline& pipeline, const Pipeline::Progress& progress, const cv::Mat& seen) {
    video->follow(progress);
    picture.follow(progress);
    video->add(pipeline, seen);
    drawn.push_back(picture.draw(pipeline, seen));
  });
  EXPECT_FALSE(fs::exists(path)) << "it appears when it is whole";
  video->finish();
  const std::vector<cv::Mat> read = framesOf(path);
  fs::remove(path);
  ASSERT_EQ(read.size(), drawn.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    ASSERT_EQ(read[i].size(), cv::Size(kCompositeWidth, kCompositeHeight));
    cv::Mat difference;
    cv::absdiff(read[i], drawn[i], difference);
    EXPECT_LT(cv::mean(difference.reshape(1))[0], 4.0) << "frame " << i << ": more than a codec's loss";
  }
}

INSTANTIATE_TEST_SUITE_P(Endings, VideoFile, ::testing::Values(".mp4", ".avi"));

TEST(RunPicture, OfTheSameRunIsTheSame) {
  std::vector<cv::Mat> pictures[2];
  for (auto& drawn : pictures) {
    RunPicture picture;
    drive([&](const Pipeline& pipeline, const Pipeline::Progress& progress, const cv::Mat& seen) {
      picture.follow(progress);
      drawn.push_back(picture.draw(pipeline, seen));
    });
  }
  for (std::size_t i = 0; i < pictures[0].size(); ++i) {
    EXPECT_EQ(cv::norm(pictures[0][i], pictures[1][i], cv::NORM_INF), 0.0);
    EXPECT_GT(i == 0 ? 1.0 : cv::norm(pictures[0][i], pictures[0][i - 1], cv::NORM_INF), 0.0);
  }
}

TEST(RunVideo, SaysInOneLineWhatCannotBeWritten) {
  const auto complaint = [](const std::string& path) -> std::string {
    try {
      RunVideo video(path, 10.0);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(complaint("run.gif").find("run.gif: a video's name must end with .mp4 or .avi"),
            std::string::npos);
  EXPECT_NE(complaint("/nowhere/run.avi").find("/nowhere/run.avi: cannot write"), std::string::npos);
}

}  // namespace
}  // namespace ratslam
