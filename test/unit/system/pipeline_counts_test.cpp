/// What a pipeline counts and says of its streams, whatever becomes of the streams.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "ratslam/common/state.h"
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

/// The images come before the odometry that reaches them, as they do when nodes run.
Pipeline::Progress drive(Pipeline& pipeline, int from, int to) {
  Pipeline::Progress last;
  for (int frame = from; frame < to; ++frame) {
    EXPECT_TRUE(pipeline.addImage(frameOf(frame)).refusals.empty());
    last = pipeline.addOdometry(motion(frame));
  }
  return last;
}

TEST(PipelineCounts, WhatTheMapRefusesIsNoFaultOfTheImage) {
  State state;
  State empty;
  {
    Pipeline pipeline(params(), {});
    pipeline.save(empty);
    drive(pipeline, 0, 60);
    EXPECT_EQ(pipeline.refusedDecisions(), 0U);
    pipeline.save(state);
  }
  state.child("experience_map") =
      empty.child("experience_map");  // does not know the places of the pose cells
  Pipeline pipeline(params(), {});
  pipeline.load(state, true);
  const Pipeline::Progress progress = drive(pipeline, 60, 120);
  EXPECT_FALSE(progress.map_refusals.empty());
  EXPECT_GT(pipeline.refusedDecisions(), 1U);
  EXPECT_NE(pipeline.firstRefusal(), "");
  State saved;
  pipeline.save(saved);
  Pipeline again(params(), {});
  again.load(saved, true);
  EXPECT_EQ(again.refusedDecisions(), pipeline.refusedDecisions());
  EXPECT_EQ(again.firstRefusal(), pipeline.firstRefusal());
}

TEST(PipelineCounts, UnmeasuredStretchesOfEarlierLapsAndDrivesStayCounted) {
  Pipeline pipeline(params(), {});
  for (std::size_t lap = 1; lap <= 2; ++lap) {
    drive(pipeline, 0, 20);
    drive(pipeline, 60, 80);  // after 4 s of silence
    EXPECT_EQ(pipeline.unmeasuredStretches(), lap);
  }
  drive(pipeline, 0, 20);
  EXPECT_EQ(pipeline.unmeasuredStretches(), 2U);
  State state;
  pipeline.save(state);
  for (const bool go_on : {true, false}) {
    Pipeline next(params(), {});
    next.load(state, go_on);
    EXPECT_EQ(next.unmeasuredStretches(), 2U) << go_on;
    drive(next, 20, 40);
    EXPECT_EQ(next.unmeasuredStretches(), 2U) << go_on;
  }
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
