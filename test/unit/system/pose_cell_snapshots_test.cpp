#include "ratslam/system/pose_cell_snapshots.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "ratslam/dataset/csv.h"

namespace ratslam {
namespace {

constexpr int kFrames = 30;

/// Drives straight on for three seconds and returns the file that is left.
std::string fileOf(const SnapshotMoments& moments) {
  PipelineParams params;
  params.local_view.shift_match = 0;
  Pipeline pipeline(params, {});
  PoseCellSnapshots snapshots(moments);
  for (int frame = 0; frame < kFrames; ++frame) {
    OdometrySample sample;
    sample.stamp = 5000000000 + frame * Stamp{100000000};
    sample.speed = 5.0;
    snapshots.follow(pipeline.addOdometry(sample), pipeline.poseCells().cells());
    const cv::Mat image(10, 10, CV_8UC1, cv::Scalar(8 * frame));
    snapshots.follow(pipeline.addImage({sample.stamp, image}), pipeline.poseCells().cells());
  }
  const auto path = std::filesystem::temp_directory_path() / "pose_cell_snapshots_test.csv";
  snapshots.write(path.string());
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  std::filesystem::remove(path);
  return text.str();
}

/// Activity of each snapshot, added up, by its stamp.
std::map<std::string, double> sumsOf(const std::string& file) {
  std::istringstream lines(file);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "stamp,layer,row,column,activity");
  std::map<std::string, double> sums;
  while (std::getline(lines, line)) {
    const auto words = splitCsv(line);
    sums[words.at(0)] += std::stod(words.at(4));
  }
  return sums;
}

TEST(PoseCellSnapshots, AreTakenAtTheTimesAskedForAndHoldAllActivity) {
  const auto sums = sumsOf(fileOf(SnapshotMoments::fromTimes("0,0.75,2.9,100")));
  ASSERT_EQ(sums.size(), 3U) << "the drive ends before the last of the times";
  EXPECT_EQ(sums.count("5.000000000"), 1U);
  EXPECT_EQ(sums.count("5.800000000"), 1U) << "the first decision at or past the time";
  EXPECT_EQ(sums.count("7.900000000"), 1U);
  for (const auto& [stamp, sum] : sums) EXPECT_NEAR(sum, 1.0, 1e-3) << stamp;
}

TEST(PoseCellSnapshots, TimesBehindTheEndOfTheDriveAreNamed) {
  PoseCellSnapshots snapshots(SnapshotMoments::fromTimes("0.5,2,100"));
  const PoseCells cells{PoseCellParams{}};
  const auto decideAt = [&](Stamp stamp) {
    Pipeline::Progress progress;
    progress.decisions.emplace_back();
    progress.decisions.back().view.stamp = stamp;
    snapshots.follow(progress, cells);
  };
  decideAt(5000000000);
  decideAt(6500000000);
  EXPECT_EQ(
      snapshots.complaint(),
      "--pose-cells-at: value 2: the last decision is 1.5 s after the first; 2 of the 3 times lie behind it");
  decideAt(200000000000);
  EXPECT_EQ(snapshots.complaint(), std::nullopt);
}

TEST(PoseCellSnapshots, AreSpreadEvenlyAndEndWithTheDrive) {
  const auto sums = sumsOf(fileOf(SnapshotMoments::evenly(3, kFrames)));
  ASSERT_EQ(sums.size(), 3U);
  EXPECT_EQ(sums.begin()->first, "5.900000000");
  EXPECT_EQ(sums.rbegin()->first, "7.900000000");
  EXPECT_TRUE(sumsOf(fileOf(SnapshotMoments::evenly(6, 0))).empty());
}

TEST(PoseCellSnapshots, AreTheSameInEveryRun) {
  const SnapshotMoments moments = SnapshotMoments::evenly(4, kFrames);
  EXPECT_EQ(fileOf(moments), fileOf(moments));
}

TEST(SnapshotMoments, FaultyTimesAreNamed) {
  for (const char* text : {"soon", "2,1", "1,1", "-1", "1,,2"}) {
    try {
      SnapshotMoments::fromTimes(text);
      FAIL() << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("pose-cells-at: value " + std::string(text)),
                std::string::npos);
    }
  }
}

}  // namespace
}  // namespace ratslam
