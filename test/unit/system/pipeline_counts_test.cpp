/// What a pipeline counts and says of its streams, whatever becomes of the streams.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "ratslam/system/pipeline.h"

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100000000;

PipelineParams params() {
  PipelineParams p;
  p.local_view.view_template.x_size = 32;
  p.local_view.view_template.y_size = 8;
  p.local_view.shift_match = 3;
  return p;
}

/// Another random texture for each frame.
ImageFrame frameOf(int frame) {
  cv::Mat image(40, 160, CV_8UC1);
  cv::RNG random(static_cast<std::uint64_t>(frame) + 1);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  return {frame * kTenth, image};
}

OdometrySample motion(int frame) {
  OdometrySample sample;
  sample.stamp = frame * kTenth;
  sample.speed = 10.0;
  return sample;
}

/// A sample that jumps ahead is held until an image reaches its stamp.
TEST(PipelineCounts, SamplesThatAnImageAcceptsAreDoubtedLikeOthers) {
  PipelineParams strict = params();
  strict.odometry_stream.odometry_reset = 0.05;  // each sample jumps ahead
  Pipeline pipeline(strict, {});
  for (int frame = 0; frame < 60; ++frame) {
    OdometrySample sample = motion(frame);
    sample.sideways = 5.0;
    pipeline.addOdometry(sample);
    EXPECT_EQ(pipeline.expectImage(sample.stamp).odometry.size(), 1U);
    pipeline.addImage(frameOf(frame));
  }
  ASSERT_EQ(pipeline.odometryDoubts().size(), 1U);
  EXPECT_NE(pipeline.odometryDoubts().front().find("linear.y"), std::string::npos);
}

}  // namespace
}  // namespace ratslam
