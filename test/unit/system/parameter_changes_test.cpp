#include "ratslam/system/parameter_changes.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "ratslam/common/angles.h"
#include "ratslam/system/pipeline.h"

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100000000;
constexpr int kFrames = 120;

/// Twice round: a strip of random columns that comes back after half of the frames.
cv::Mat view(int frame) {
  cv::Mat street(40, 1000, CV_8UC1);
  cv::RNG random(7);
  random.fill(street, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(street, street, cv::Size(0, 0), 6.0);
  cv::normalize(street, street, 0, 255, cv::NORM_MINMAX);
  return street.colRange((frame % (kFrames / 2)) * 10, (frame % (kFrames / 2)) * 10 + 160).clone();
}

PipelineParams params() {
  PipelineParams p;
  p.local_view.view_template = {0, -1, 0, -1, 32, 8, 0.0, 0, 0.0};
  p.local_view.match_threshold = 0.02;
  p.local_view.shift_match = 3;
  p.local_view.step_match = 1;
  p.pose_cells.experience_distance = 1.0;
  return p;
}

/// All that a drive decides, line by line; `change` may tell the pipeline of changes before it.
template <class Change>
std::vector<std::string> drive(Change&& change) {
  Pipeline pipeline(params(), {});
  change(pipeline);
  std::vector<std::string> lines;
  for (int frame = 0; frame < kFrames; ++frame) {
    OdometrySample sample;
    sample.stamp = frame * kTenth;
    sample.speed = 10.0;
    sample.yaw_rate = 2.0 * degreesToRadians(360.0) / (kFrames * 0.1);
    pipeline.addOdometry(sample);
    const auto progress = pipeline.addImage({frame * kTenth, view(frame)});
    for (const PoseCellDecision& decision : progress.decisions) {
      std::ostringstream line;
      line.precision(17);
      line << decision.view.stamp << ' ' << decision.view.id << ' ' << static_cast<int>(decision.action.kind)
           << ' ' << decision.action.dest_id << ' ' << decision.estimate.x << ' ' << decision.estimate.th
           << ' ' << pipeline.map().robotPose().x << ' ' << pipeline.map().robotPose().yaw;
      lines.push_back(line.str());
    }
  }
  return lines;
}

const auto kNothing = [](Pipeline&) {};

TEST(ParameterChanges, ToTheSameValuesChangeNothing) {
  const auto changed = drive([](Pipeline& pipeline) {
    for (const int frame : {0, 30, 31, 90}) {
      pipeline.change(frame * kTenth, params().local_view);
      pipeline.change(frame * kTenth, params().pose_cells);
      pipeline.change(frame * kTenth, params().experience_map);
    }
  });
  EXPECT_EQ(changed, drive(kNothing));
}

TEST(ParameterChanges, HoldForWhatIsLaterThanTheirStampAndForNothingBefore) {
  const auto before = drive(kNothing);
  const auto after = drive([](Pipeline& pipeline) {
    LocalViewParams nothing_alike = params().local_view;
    nothing_alike.match_threshold = 0.0;
    pipeline.change(80 * kTenth, nothing_alike);
  });
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const bool later = std::stoll(before[i]) > 80 * kTenth;
    EXPECT_EQ(before[i] == after[i], !later) << before[i] << "\n" << after[i];
  }
}

// Nor need anything have been seen before the first change.
TEST(ParameterChanges, OfTheEndOfAnOldTimeHoldFromTheBeginningOfTheNewOne) {
  struct Part {
    Part() = default;
    explicit Part(int given) : value(given) {}
    int value = 0;
    void save(State&) const {}
    void load(const State&) {}
    void setLearning(bool) {}
    bool learning() const { return true; }
  };
  TimedChanges<int> changes;
  Part part;
  changes.applyBefore(600, part);
  changes.add(600, 1);
  changes.add(900, 2);
  changes.applyBefore(1, part);
  EXPECT_EQ(part.value, 1) << "the recording is played again";
  changes.applyBefore(901, part);
  EXPECT_EQ(part.value, 2);
}

TEST(ParameterChanges, TheNewestOfSeveralThatAreDueHolds) {
  const auto twice = drive([](Pipeline& pipeline) {
    LocalViewParams other = params().local_view;
    other.match_threshold = 0.0;
    pipeline.change(-5, other);
    pipeline.change(-4, params().local_view);
  });
  EXPECT_EQ(twice, drive(kNothing));
}

class ChangeFile : public testing::Test {
 protected:
  void SetUp() override { path_ = std::filesystem::temp_directory_path() / "parameter_changes_test.csv"; }
  void TearDown() override { std::filesystem::remove(path_); }
  std::vector<ParameterChange> read(const std::string& text) {
    std::ofstream(path_) << text;
    return readParameterChanges(path_);
  }
  /// What is said of a file's changes; empty where they are taken.
  std::string complaint(const std::string& text) {
    try {
      Pipeline pipeline(params(), {});
      addChanges(read(text), ParameterMap(), pipeline);
    } catch (const std::exception& e) {
      return e.what();
    }
    return "";
  }
  std::string path_;
};

TEST_F(ChangeFile, IsReadLineByLine) {
  const auto changes =
      read("after_ns,name,value\n1600000000123456789,vt_match_threshold,0.05\n-1,exp_loops,7\n");
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].after, 1600000000123456789);
  EXPECT_EQ(changes[0].name, "vt_match_threshold");
  EXPECT_EQ(changes[1].value, "7");
}

TEST_F(ChangeFile, TheOrderOfTheLinesDoesNotMatter) {
  const std::string early = "2000000000,pc_vt_inject_energy,0\n";
  const std::string late = "8000000000,exp_delta_pc_threshold,0.2\n";
  const auto driven = [this](const std::string& text) {
    return drive([&](Pipeline& pipeline) { addChanges(read(text), ParameterMap(), pipeline); });
  };
  const auto sorted = driven(early + late);
  EXPECT_NE(sorted, driven(early));
  EXPECT_EQ(sorted, driven(late + early));
}

TEST_F(ChangeFile, AStampThatTheDriveDoesNotReachIsNamed) {
  const auto changes =
      read("after_ns,name,value\n10,exp_loops,7\n99,exp_loops,8\n400,vt_match_threshold,0.05\n");
  EXPECT_FALSE(changesNeverReached(changes, 401));
  const std::string said = changesNeverReached(changes, 99).value_or("");
  EXPECT_NE(said.find("_test.csv:3: exp_loops never changed, because after_ns=99 is not before"),
            std::string::npos)
      << said;
  EXPECT_NE(said.find("(2 of 3 changes)"), std::string::npos) << said;
}

TEST_F(ChangeFile, OfAnotherFormIsRefusedWithItsLine) {
  EXPECT_NE(complaint("after_ns,name,value\nsoon,exp_loops,7\n").find("_test.csv:2: 'soon,exp_loops,7'"),
            std::string::npos);
  EXPECT_NE(complaint("12,exp_loops\n").find("after_ns,name,value"), std::string::npos);
}

TEST_F(ChangeFile, MayChangeThresholdsAndGainsWithinBoundsAlone) {
  EXPECT_EQ(complaint("1,pc_vt_restore,0.1\n"), "");
  EXPECT_NE(complaint("1,template_x_size,20\n").find("_test.csv:1: template_x_size: it cannot change"),
            std::string::npos);
  EXPECT_NE(
      complaint("1,vt_match_threshold,2\n").find("_test.csv:1: vt_match_threshold: value 2 is not allowed"),
      std::string::npos);
  EXPECT_NE(complaint("1,exp_loops,7\n2,exp_loops,many\n").find("_test.csv:2)"), std::string::npos);
}

}  // namespace
}  // namespace ratslam
