#include "ratslam/system/local_view_stage.h"

#include <gtest/gtest.h>

#include <memory>
#include <opencv2/imgproc.hpp>

#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr Stamp kSecond = 1'000'000'000;

/// A small local view with vt_recall belief.
LocalViewParams believing() {
  LocalViewParams params;
  params.recall.kind = "belief";
  params.view_template.x_size = 60;
  params.view_template.y_size = 10;
  return params;
}

/// A picture of its own for each number.
cv::Mat pictureOf(int number) {
  cv::Mat blocks(4, 8, CV_8UC1);
  cv::RNG(static_cast<std::uint64_t>(number) + 1).fill(blocks, cv::RNG::UNIFORM, 0, 255);
  cv::Mat picture;
  cv::resize(blocks, picture, {80, 40}, 0, 0, cv::INTER_NEAREST);
  return picture;
}

TEST(LocalViewStage, ACheckpointKnowsASampleAboutWhichAnImageHasDecided) {
  // A sample that goes far back or ahead is held. With images that go on beside it, an image decides about it.
  for (const int images_before : {1, 20}) {
    LocalViewStage whole(believing(), RecallGeometryParams{});
    std::unique_ptr<LocalViewStage> resumed;
    const auto each = [&](const auto& act) {
      act(whole);
      if (resumed) act(*resumed);
    };
    int number = 0;
    const auto image = [&](Stamp stamp) {
      ImageFrame frame;
      frame.stamp = stamp;
      frame.image = pictureOf(number++);
      each([&](LocalViewStage& stage) {
        stage.addFrame(frame);
        stage.drain();
      });
    };
    const auto odometry = [&](Stamp stamp) {
      OdometrySample sample;
      sample.stamp = stamp;
      sample.speed = 1.0;
      sample.covariance = TwistCovariance::Identity() * 1e-4;
      each([&](LocalViewStage& stage) {
        stage.addOdometry(sample);
        stage.drain();
      });
    };
    Stamp now = 0;
    for (int k = 0; k < images_before; ++k, now += kSecond / 10) {
      odometry(now);
      image(now + kSecond / 20);
    }
    if (images_before > 1) {  // a pause of both
      now += 3 * kSecond;
      odometry(now);
      image(now + kSecond / 100);
    }
    State saved;
    whole.save(saved);
    resumed = std::make_unique<LocalViewStage>(believing(), RecallGeometryParams{});
    resumed->load(State::fromBytes(saved.toBytes()));
    for (int k = 0; k < 30; ++k) {
      now += kSecond / 10;
      odometry(now);
      image(now - kSecond / 20);
    }
    State a;
    State b;
    whole.save(a);
    resumed->save(b);
    EXPECT_EQ(a.toBytes(), b.toBytes()) << images_before << " images before";
  }
}

TEST(LocalViewStage, OdometryThatNoImageAsksForIsBoundedAndViewsComeAgain) {
  LocalViewStage stage(believing(), RecallGeometryParams{});
  ASSERT_TRUE(stage.needsOdometry());
  const auto bytes = [&stage] {
    State state;
    stage.save(state);
    return state.toBytes().size();
  };
  std::size_t after_an_hour = 0;
  Stamp stamp = 0;
  for (int k = 0; k <= 4 * 360000; ++k, stamp += kSecond / 100) {  // at 100 Hz
    OdometrySample sample;
    sample.stamp = stamp;
    sample.speed = 0.01;
    sample.covariance = TwistCovariance(1e-4 * TwistCovariance::Identity());
    stage.addOdometry(sample);
    if (k == 360000) after_an_hour = bytes();
  }
  EXPECT_LE(bytes(), after_an_hour * 11 / 10);
  ImageFrame frame;
  frame.stamp = stamp - kSecond;
  frame.image = cv::Mat(240, 320, CV_8UC1);
  cv::randu(frame.image, 0, 255);
  EXPECT_EQ(stage.addFrame(frame), EventVerdict::kAccepted);
  EXPECT_EQ(stage.drain().size(), 1U);
}

/// A drive on a ring of places, round and round.
class Ring {
 public:
  explicit Ring(LocalViewStage& stage) : stage_(stage) {
    sample_.speed = 10.0;
    sample_.yaw_rate = 2.0 * M_PI * 10.0 / kPlaces;
    sample_.covariance = TwistCovariance(1e-4 * TwistCovariance::Identity());
  }
  static constexpr int kPlaces = 40;

  /// The events of `views` views from a place on. @param seed  of the places' looks
  std::vector<ViewEvent> drive(int views, int seed, int first = 0) {
    std::vector<ViewEvent> events;
    for (int k = 0; k < views; ++k) {
      sample_.stamp += kSecond / 10;
      stage_.addOdometry(sample_);
      cv::RNG random(static_cast<std::uint64_t>(1000 * seed + (first + k) % kPlaces + 1));
      ImageFrame frame;
      frame.stamp = sample_.stamp;
      frame.image = cv::Mat(240, 320, CV_8UC1);
      random.fill(frame.image, cv::RNG::UNIFORM, 0, 255);
      cv::blur(frame.image, frame.image, {25, 25});
      cv::normalize(frame.image, frame.image, 0, 255, cv::NORM_MINMAX);
      stage_.addFrame(frame);
      for (const ViewObservation& seen : stage_.drain()) events.push_back(seen.view);
    }
    return events;
  }

 private:
  LocalViewStage& stage_;
  OdometrySample sample_;
};

/// Whoever goes on in a map from elsewhere must not be believed to be where the drive before ended.
TEST(LocalViewStage, NothingOfAnotherPlaceIsRecalledAfterAnInterruption) {
  LocalViewStage stage(believing(), RecallGeometryParams{});
  Ring ring(stage);
  ring.drive(Ring::kPlaces, 1);
  int recalled = 0;
  for (const ViewEvent& event : ring.drive(Ring::kPlaces - 5, 1)) recalled += event.learned ? 0 : 1;
  ASSERT_GT(recalled, Ring::kPlaces / 2) << "the drive ends on known ground";
  stage.interrupt();
  for (const ViewEvent& event : ring.drive(10, 2)) EXPECT_TRUE(event.learned) << event.id;
  stage.interrupt();
  int right = 0;
  for (const ViewEvent& event : ring.drive(15, 1, 20)) right += event.learned ? 0 : 1;
  EXPECT_GT(right, 5) << "and it wakes up where it knows its way";
}

/// Places of different drives must not be compared by dead reckoning.
TEST(LocalViewStage, AnInterruptionBeginsAnEpochThatNoViewHasHad) {
  LocalViewStage stage(believing(), RecallGeometryParams{});
  OdometrySample sample;
  sample.speed = 1.0;
  ImageFrame frame;
  frame.image = cv::Mat(240, 320, CV_8UC1);
  std::uint32_t largest = stage.epoch();
  for (int lap = 0; lap < 3; ++lap) {  // of a looped bag
    for (int k = 1; k <= 50; ++k) {
      sample.stamp = frame.stamp = k * (kSecond / 10);
      cv::randu(frame.image, 0, 255);
      stage.addOdometry(sample);
      stage.addFrame(frame);
      stage.drain();
      largest = std::max(largest, stage.epoch());
    }
  }
  ASSERT_GE(largest, 2U);
  stage.interrupt();
  EXPECT_GT(stage.epoch(), largest);
}

/// A message that carries no stamp, or one of another source, says nothing of how far the robot has come.
TEST(LocalViewStage, ASampleOfAnotherTimeChangesNoCertainty) {
  const auto varianceAfter = [](bool with_stray) {
    LocalViewStage stage(believing(), RecallGeometryParams{});
    OdometrySample sample;
    sample.speed = 10.0;
    sample.covariance = TwistCovariance(1e-2 * TwistCovariance::Identity());
    ImageFrame frame;
    frame.image = cv::Mat(240, 320, CV_8UC1);
    sample.stamp = 1'000'000 * kSecond;
    for (int k = 0; k < 40; ++k) {
      sample.stamp += kSecond / 10;
      stage.addOdometry(sample);
      frame.stamp = sample.stamp - kSecond / 20;
      cv::randu(frame.image, 0, 255);
      stage.addFrame(frame);
      stage.drain();
      if (!with_stray || k != 20) continue;
      OdometrySample stray = sample;
      stray.stamp = 0;
      stage.addOdometry(stray);
      frame.stamp += kSecond / 40;
      stage.addFrame(frame);
      stage.drain();
    }
    State state;
    stage.save(state);
    return state.child("belief").child("here").get<double>("forward_variance");
  };
  const double clean = varianceAfter(false);
  ASSERT_GT(clean, 0.0);
  EXPECT_NEAR(varianceAfter(true), clean, 0.1 * clean);
}

/// If only the odometry's clock was set back, its samples wait for images that may never go back as well.
TEST(LocalViewStage, SamplesThatWaitForTheImagesToGoBackAreBounded) {
  LocalViewStage stage(believing(), RecallGeometryParams{});
  OdometrySample sample;
  sample.speed = 1.0;
  ImageFrame frame;
  frame.image = cv::Mat(240, 320, CV_8UC1);
  cv::randu(frame.image, 0, 255);
  for (int k = 0; k < 100; ++k) {
    sample.stamp = frame.stamp = 1'000'000 * kSecond + k * (kSecond / 10);
    stage.addOdometry(sample);
    if (k < 50) stage.addFrame(frame);
    stage.drain();
  }
  const auto bytesAfter = [&](int from, int to) {
    for (int k = from; k < to; ++k) {
      sample.stamp = 1000 * kSecond + k * (kSecond / 10);
      stage.addOdometry(sample);
    }
    State state;
    stage.save(state);
    return state.toBytes().size();
  };
  const std::size_t full = bytesAfter(0, 15000);
  EXPECT_LE(bytesAfter(15000, 45000), full * 11 / 10);
}

/// Who has slept knows no longer where the places are: it must not exclude those where the robot is now. What it saw
/// meanwhile lies apart from both.
TEST(LocalViewStage, ASilenceOfTheOdometryBreaksDeadReckoning) {
  for (const auto& [silence, breaks] : {std::pair{1.0, 0U}, std::pair{4.0, 2U}}) {
    LocalViewStage stage(believing(), RecallGeometryParams{});
    OdometrySample sample;
    sample.speed = 10.0;
    for (int k = 0; k < 10; ++k) {
      sample.stamp += kSecond / 10;
      stage.addOdometry(sample);
    }
    sample.stamp += static_cast<Stamp>(silence * kSecond);
    stage.addOdometry(sample);
    stage.endOdometry();  // no image and no other sample shows that time has jumped
    State state;
    stage.save(state);
    EXPECT_EQ(state.child("streams").get<std::uint32_t>("epoch"), breaks) << silence;
  }
}

TEST(LocalViewStage, ImagesOfAnotherSizeThanTheCalibrationsAreRefusedAndHarmNothing) {
  RecallGeometryParams recall;
  recall.verify = "orb";
  LocalViewParams params;
  params.view_template.x_size = 60;
  params.view_template.y_size = 10;
  LocalViewStage stage(params, recall);
  CameraModel camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 300.0;
  camera.cx = 160.0;
  camera.cy = 120.0;
  stage.setCamera(camera);
  ImageFrame frame;
  const auto add = [&](const cv::Size& size, bool begins_anew) {
    frame.stamp += kSecond;
    frame.begins_anew = begins_anew;
    frame.image = cv::Mat(size, CV_8UC1);
    cv::randu(frame.image, 0, 255);
    stage.addFrame(frame);
    return stage.drain();
  };
  EXPECT_EQ(add({320, 240}, false).size(), 1U);
  for (const bool begins_anew :
       {false, true}) {  // also where a camera that was set anew sends them from now on
    try {
      add({160, 120}, begins_anew);
      FAIL();
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(
          std::string(error.what())
              .find("image size: value 160x120 is not allowed: the camera's calibration is for 320x240"),
          std::string::npos)
          << error.what();
    }
  }
  EXPECT_EQ(stage.cells().size(), 1U);
  EXPECT_EQ(add({320, 240}, true).size(), 1U);
}

}  // namespace
}  // namespace ratslam
