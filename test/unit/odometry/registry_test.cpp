#include "ratslam/odometry/registry.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <set>

#include "ratslam/common/parameter_map.h"
#include "ratslam/common/state.h"
#include "ratslam/odometry/profile/profile_odometry.h"
#include "ratslam/odometry/profile/profile_source.h"
#include "ratslam/system/pipeline.h"

namespace ratslam {
namespace {

// All that a new odometry needs, as CONTRIBUTING.md shows it: its parameters, its class, and a line to
// register it.
struct ConstantSpeedParams {
  double speed = 1.0;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("constant_speed", speed, Bounds{0.0, 100.0}, "speed of a robot that drives straight on [m/s]");
  }
  void validate() const { checkBounds(*this); }
};

class ConstantSpeed : public OdometrySource {
 public:
  using Params = ConstantSpeedParams;

  explicit ConstantSpeed(const Params& params) : params_(params) {}

  OdometrySample track(const ImageFrame& frame) override {
    OdometrySample sample;
    sample.stamp = frame.stamp;
    sample.speed = params_.speed;
    return sample;
  }

 private:
  Params params_;
};

OdometryRegistry withConstantSpeed() {
  OdometryRegistry registry = standardOdometry();
  registry.add<ConstantSpeed>("constant", "straight on");
  return registry;
}

TEST(OdometryRegistryTest, ANewOdometryIsFoundReadCheckedAndDriven) {
  const OdometryRegistry registry = withConstantSpeed();
  const OdometryKind& kind = registry.find("constant");
  EXPECT_FALSE(kind.needs_camera);
  EXPECT_EQ(kind.origin, OdometryOrigin::kImages);

  OdometryParams params(registry);
  ParameterMap map;
  map.setFromAssignment("constant_speed=2.5");
  std::set<std::string> keys;
  params.visitFields(
      [&keys](const std::string& key, auto&, const Bounds&, const char*) { keys.insert(key); });
  map.rejectUnknown(keys);
  map.read(params);
  PipelineParams small;
  small.local_view.view_template.x_size = 2;
  small.local_view.shift_match = 0;
  small.local_view.step_match = 1;
  Pipeline pipeline(small, params.make(kind, std::nullopt));
  const cv::Mat image = (cv::Mat_<std::uint8_t>(2, 2) << 1, 90, 180, 250);
  for (int frame = 0; frame < 5; ++frame) pipeline.addImage({frame * Stamp{1000000000}, image});
  const MapPose last = pipeline.map().finalTrajectory().back().pose;
  EXPECT_NEAR(std::hypot(last.x, last.y), 10.0, 1e-9);

  map.setFromAssignment("constant_speed=-1");
  EXPECT_THROW(map.read(params), std::invalid_argument);
}

TEST(OdometryRegistryTest, NamesAreTakenOnceAndUnknownOnesAreAnswered) {
  OdometryRegistry registry = withConstantSpeed();
  EXPECT_THROW(registry.add<ConstantSpeed>("constant", "again"), std::invalid_argument);
  try {
    registry.find("constnat");
    FAIL() << "accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("profile, orb, topic, constant"), std::string::npos) << e.what();
  }
}

TEST(OdometryRegistryTest, TheStandardOnesAreThere) {
  const OdometryRegistry registry = standardOdometry();
  EXPECT_FALSE(registry.find("profile").needs_camera);
  EXPECT_TRUE(registry.find("orb").needs_camera);
  EXPECT_EQ(registry.find("topic").origin, OdometryOrigin::kTopic);
  const std::string file = testing::TempDir() + "ratslam_registry_test.csv";
  std::ofstream(file) << "stamp\n";
  EXPECT_EQ(registry.find(file).origin, OdometryOrigin::kFile);
  std::remove(file.c_str());
  EXPECT_THROW(OdometryParams().make(registry.find("orb"), std::nullopt), std::invalid_argument);
  EXPECT_EQ(OdometryParams().of<ProfileOdometryParams>().camera_hz, ProfileOdometryParams().camera_hz);
}

TEST(ProfileSourceTest, BridgesWhatItCannotSeeAndGoesOnFromASavedState) {
  cv::Mat street(20, 300, CV_8UC1);
  cv::RNG(3).fill(street, cv::RNG::UNIFORM, 0, 256);
  const auto frame = [&street](int i, ImageQuality quality = ImageQuality::kUsable) {
    // It grows brighter, or the profiles of a mere turn would differ by nothing.
    cv::Mat image;
    street.colRange(3 * i, 3 * i + 100).convertTo(image, -1, 0.5, 5.0 * i);
    return ImageFrame{i * Stamp{100000000}, image, quality};
  };
  ProfileSource source{ProfileOdometryParams{}};
  source.track(frame(0));
  const OdometrySample seen = source.track(frame(1));
  EXPECT_FALSE(seen.bridged);
  EXPECT_GT(seen.speed, 0.0);
  EXPECT_NE(seen.yaw_rate, 0.0);
  const OdometrySample blind = source.track(frame(2, ImageQuality::kBlank));
  EXPECT_TRUE(blind.bridged);
  EXPECT_EQ(blind.speed, seen.speed);
  EXPECT_EQ(blind.yaw_rate, 0.0);

  State state;
  source.save(state);
  ProfileSource other{ProfileOdometryParams{}};
  other.load(state);
  for (ProfileSource* one : {&source, &other}) {
    const OdometrySample again = one->track(frame(3));
    EXPECT_TRUE(again.bridged) << "nothing is known of the motion since the image before";
    EXPECT_EQ(again.speed, seen.speed);
    const OdometrySample measured = one->track(frame(4));
    EXPECT_FALSE(measured.bridged);
    EXPECT_NEAR(measured.yaw_rate, seen.yaw_rate, 1e-9);
  }
  ImageFrame anew = frame(0);
  anew.begins_anew = true;
  EXPECT_EQ(source.track(anew).speed, 0.0);
}

}  // namespace
}  // namespace ratslam
