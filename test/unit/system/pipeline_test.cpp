#include "ratslam/system/pipeline.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "ratslam/common/state.h"
#include "ratslam/dataset/odometry_file.h"
#include "ratslam/odometry/profile/profile_source.h"
#include "ratslam/system/run_log.h"
#include "street.h"

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100000000;
constexpr int kFrames = 240;

/// Driving moves the window over the street; two laps of 120 frames show the same.
cv::Mat view(int frame) {
  static_assert(kFrames == 240, "two laps");
  return streetView(1400, (frame % 120) * 10);
}

/// Twice round a square of 30 m a side at 10 m/s, turning at the corners.
OdometrySample motion(int sample, double period) {
  OdometrySample odometry;
  odometry.stamp = stampFromSeconds(sample * period);
  const double t = sample * period;
  odometry.speed = sample == 0 ? 0.0 : 10.0;
  const double within = std::fmod(t, 3.0);
  // From 2.5 s on, which sums of tenths need not reach: five tenths make the corner, and the square closes.
  odometry.yaw_rate = within > 2.49 ? degreesToRadians(90.0) / 0.5 : 0.0;
  return odometry;
}

std::string describe(const ExperienceMap& map) {
  std::ostringstream text;
  text.precision(17);
  for (const auto& path : {map.onlineTrajectory(), map.finalTrajectory()}) {
    for (const StampedPose& p : path)
      text << p.stamp << ' ' << p.pose.x << ' ' << p.pose.y << ' ' << p.pose.yaw << '\n';
  }
  return text.str();
}

/// The whole drive in one process.
std::string runPipeline(double odometry_period) {
  Pipeline pipeline(streetParams(), {});
  int sample = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    while (motion(sample, odometry_period).stamp <= frame * kTenth) {
      pipeline.addOdometry(motion(sample++, odometry_period));
    }
    pipeline.addImage({frame * kTenth, view(frame)});
  }
  for (int i = 0; i < 5; ++i) pipeline.addOdometry(motion(sample++, odometry_period));
  return describe(pipeline.map());
}

/// The same drive as separate nodes whose messages arrive in bursts of various lengths.
std::string runStages(double odometry_period, int burst) {
  LocalViewCells local_view(streetParams().local_view);
  PoseCellStage pose_cells(streetParams().pose_cells);
  MapStage map(streetParams().experience_map, GeometrySource::kNone);
  int frame = 0;
  int sample = 0;
  const Stamp end = motion(0, odometry_period).stamp + kFrames * kTenth;
  std::vector<OdometrySample> late_for_the_map;
  while (frame < kFrames || motion(sample, odometry_period).stamp < end) {
    for (int i = 0; i < burst && frame < kFrames; ++i, ++frame) {
      pose_cells.addView(local_view.observe(frame * kTenth, view(frame)));
    }
    for (int i = 0; i < 3 * burst && motion(sample, odometry_period).stamp < end; ++i, ++sample) {
      pose_cells.addOdometry(motion(sample, odometry_period));
      late_for_the_map.push_back(motion(sample, odometry_period));
    }
    for (const PoseCellDecision& decision : pose_cells.drain()) map.addDecision(decision.action);
    map.drain();
    for (const OdometrySample& late : late_for_the_map) map.addOdometry(late);
    late_for_the_map.clear();
    map.drain();
  }
  return describe(map.map());
}

TEST(Pipeline, NodesAndOneProcessGiveTheSameMapWhateverTheArrivalOrder) {
  for (const double period : {0.1, 0.037}) {
    const std::string expected = runPipeline(period);
    for (const int burst : {1, 7, 60, kFrames}) {
      EXPECT_EQ(runStages(period, burst), expected) << "period " << period << ", bursts of " << burst;
    }
  }
}

TEST(Pipeline, SecondLapIsRecalled) {
  Pipeline pipeline(streetParams(), {});
  std::size_t recalls = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    pipeline.addOdometry(motion(frame, 0.1));
    const auto progress = pipeline.addImage({frame * kTenth, view(frame)});
    if (frame >= 120 && !progress.views[0].learned) ++recalls;
  }
  EXPECT_GT(recalls, 100U);
  bool linked_back = false;
  for (const Link& link : pipeline.map().graph().links()) linked_back = linked_back || link.recall;
  EXPECT_TRUE(linked_back);
}

TEST(Pipeline, BadOdometryIsCountedAndLeavesNoTrace) {
  Pipeline clean(streetParams(), {});
  Pipeline dirty(streetParams(), {});
  for (int frame = 0; frame < 60; ++frame) {
    OdometrySample bad = motion(frame, 0.1);
    bad.stamp -= kTenth / 2;
    bad.speed = std::numeric_limits<double>::quiet_NaN();
    dirty.addOdometry(bad);
    for (Pipeline* pipeline : {&clean, &dirty}) {
      pipeline->addOdometry(motion(frame, 0.1));
      pipeline->addImage({frame * kTenth, view(frame)});
    }
  }
  EXPECT_EQ(dirty.droppedOdometry(), 60U);
  EXPECT_EQ(describe(dirty.map()), describe(clean.map()));
}

TEST(Pipeline, OneSampleAheadOfTimeIsDroppedAndTheMapIsAsWithoutIt) {
  const auto run = [](bool belief, int at, double ahead) {
    PipelineParams with = streetParams();
    if (belief) with.local_view.recall.kind = "belief";
    Pipeline pipeline(with, {});
    const std::size_t dropped = ahead > 0.0 ? 1 : 0;
    for (int frame = 0; frame < kFrames; ++frame) {
      OdometrySample sample = motion(frame, 0.1);
      if (frame == at && ahead > 0.0) {
        OdometrySample wrong = motion(frame, 0.1);
        wrong.stamp += stampFromSeconds(ahead) - kTenth / 2;
        pipeline.addOdometry(wrong);
      }
      pipeline.addOdometry(sample);
      pipeline.addImage({frame * kTenth, view(frame)});
    }
    pipeline.endOdometry();
    EXPECT_EQ(pipeline.droppedOdometry(), dropped);
    EXPECT_EQ(pipeline.firstDrop().find("lies ahead") != std::string::npos, dropped > 0)
        << pipeline.firstDrop();
    return describe(pipeline.map());
  };
  for (const bool belief : {false, true}) {
    const std::string expected = run(belief, 0, 0.0);
    for (const int at : {0, 1, 100}) {
      for (const double ahead : {1.5, 5.0, 1000.0}) {
        EXPECT_EQ(run(belief, at, ahead), expected) << belief << ' ' << at << ' ' << ahead;
      }
    }
  }
}

/// The images' clock: one image ahead of time, or all set back for good from an image on.
TEST(Pipeline, ImagesThatNeverReachTheMapAreCounted) {
  for (const double set : {5.0, 1000.0, -1000.0}) {
    Pipeline pipeline(streetParams(), {});
    std::size_t mapped = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
      const bool wrong = set > 0.0 ? frame == 100 : frame >= 100;
      const Stamp stamp = Stamp{2000} * 10 * kTenth + frame * kTenth;
      OdometrySample shifted = motion(frame, 0.1);
      shifted.stamp = stamp;
      mapped += pipeline.addOdometry(shifted).mapped.size();
      mapped += pipeline
                    .addImage({stamp + (wrong ? stampFromSeconds(std::abs(set)) * (set > 0.0 ? 1 : -1) : 0),
                               view(frame)})
                    .mapped.size();
    }
    mapped += pipeline.endOdometry().mapped.size();
    const std::size_t left =
        pipeline.waitingViews().size() + pipeline.unreachedViews() + pipeline.lateViews();
    EXPECT_EQ(mapped + left, static_cast<std::size_t>(kFrames)) << set;
    EXPECT_EQ(mapped, set > 0.0 ? 239U : 100U) << set;
    EXPECT_EQ(pipeline.lateViews(), set > 0.0 ? 1U : 0U) << set;
  }
}

TEST(Pipeline, ALoopedRecordingKeepsTheMapAndLinksNothingAcrossTheJump) {
  Pipeline pipeline(streetParams(), {});
  for (int lap = 0; lap < 2; ++lap) {
    for (int frame = 0; frame < 100; ++frame) {
      pipeline.addOdometry(motion(frame, 0.1));
      pipeline.addImage({frame * kTenth, view(frame)});
    }
  }
  for (const Link& link : pipeline.map().graph().links()) EXPECT_GE(link.duration_s, 0.0);
  for (const StampedPose& stamped : pipeline.map().finalTrajectory()) {
    EXPECT_TRUE(std::isfinite(stamped.pose.x) && std::isfinite(stamped.pose.y));
  }
  // The first place of the second lap is the first of the recording, 60 m from where the recording ends: a
  // link between the two would say that they are one.
  const auto& experiences = pipeline.map().graph().experiences();
  for (const Link& link : pipeline.map().graph().links()) {
    const MapPose& a = experiences[link.from].pose;
    const MapPose& b = experiences[link.to].pose;
    EXPECT_NEAR(std::hypot(b.x - a.x, b.y - a.y), link.distance, 3.0) << link.from << " -> " << link.to;
  }
}

/// Stamps that step back a little must not put the numbers of the experiences out of step: each later creation
/// would be refused.
TEST(Pipeline, OdometryThatStepsBackLosesNothing) {
  Pipeline clean(streetParams(), {});
  Pipeline disturbed(streetParams(), {});
  for (int frame = 0; frame < kFrames; ++frame) {
    for (Pipeline* pipeline : {&clean, &disturbed}) {
      pipeline->addOdometry(motion(frame, 0.1));
      if (pipeline == &disturbed && frame % 20 == 7) {
        OdometrySample back = motion(frame, 0.1);
        back.stamp -= kTenth * 5 / 2;
        pipeline->addOdometry(back);
      }
      EXPECT_NO_THROW(pipeline->addImage({frame * kTenth, view(frame)}));
    }
  }
  EXPECT_EQ(describe(disturbed.map()), describe(clean.map()));
  EXPECT_EQ(disturbed.droppedOdometry(), static_cast<std::size_t>(kFrames / 20));
}

/// The square of motion(), as an odometry with poses that drifts a little in length tells it.
OdometrySample posedMotion(int sample, Eigen::Isometry3d& pose) {
  OdometrySample odometry = motion(sample, 0.1);
  odometry.speed *= 1.0 + 0.02 * std::sin(0.1 * sample);
  pose.rotate(Eigen::AngleAxisd(0.1 * odometry.yaw_rate, Eigen::Vector3d::UnitZ()));
  pose.translate(Eigen::Vector3d(0.1 * odometry.speed, 0.0, 0.0));
  odometry.pose = pose;
  return odometry;
}

/// Mean distance of the final trajectory from the square, by stamp, once both start alike.
double meanError(const ExperienceMap& map) {
  std::map<Stamp, Eigen::Vector2d> truth;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int frame = 0; frame < kFrames; ++frame) {
    const OdometrySample exact = motion(frame, 0.1);
    pose.rotate(Eigen::AngleAxisd(0.1 * exact.yaw_rate, Eigen::Vector3d::UnitZ()));
    pose.translate(Eigen::Vector3d(0.1 * exact.speed, 0.0, 0.0));
    truth[exact.stamp] = pose.translation().head<2>();
  }
  const std::vector<StampedPose> path = map.finalTrajectory();
  const MapPose& start = path.front().pose;
  double sum = 0.0;
  std::size_t count = 0;
  for (const StampedPose& stamped : path) {
    const auto known = truth.find(stamped.stamp);
    if (known == truth.end()) continue;
    const RelativePose seen = between(start, stamped.pose);
    const Eigen::Vector2d off = Eigen::Vector2d(seen.x, seen.y) - (known->second - truth.begin()->second);
    sum += off.norm();
    ++count;
  }
  return sum / static_cast<double>(count);
}

/// An odometry that starts again at its origin.
TEST(Pipeline, AnOdometryThatIsRestartedDoesNotSpoilTheMap) {
  const auto run = [](int silent_from, int silent_to) {
    PipelineParams p = streetParams();
    p.experience_map.exp_height = true;
    Pipeline pipeline(p, {});
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int frame = 0; frame < kFrames; ++frame) {
      const OdometrySample sample = posedMotion(frame, pose);
      if (frame == silent_to) pose = Eigen::Isometry3d::Identity();
      const bool silent = frame >= silent_from && frame < silent_to;
      if (!silent)
        pipeline.addOdometry(frame == silent_to ? [&] {
        OdometrySample first = motion(frame, 0.1);
        first.speed = first.yaw_rate = 0.0;
        first.pose = pose;
        return first;
      }() : sample);
      pipeline.addImage({frame * kTenth, view(frame)});
    }
    pipeline.settle();
    return meanError(pipeline.map());
  };
  const double undisturbed = run(kFrames, kFrames);
  EXPECT_LT(undisturbed, 1.0);
  // The length of one step is unknown: 1 m is allowed.
  EXPECT_LT(run(70, 70), 2.0 * undisturbed + 1.0);
}

/// An image that comes late by one place.
TEST(Pipeline, ALateImageIsLeftOutAndTheMapGoesOn) {
  Pipeline pipeline(streetParams(), {});
  for (int frame = 0; frame < kFrames; ++frame) {
    const int shown = frame % 50 == 20 ? frame + 1 : frame % 50 == 21 ? frame - 1 : frame;
    pipeline.addOdometry(motion(frame, 0.1));
    pipeline.addImage({shown * kTenth, view(shown)});
  }
  EXPECT_EQ(pipeline.lateViews(), 5U);
  EXPECT_EQ(pipeline.map().finalTrajectory().size(), static_cast<std::size_t>(kFrames));
}

TEST(RunLog, ARunFromTheOdometryOfAnEarlierOneIsTheSame) {
  const auto folder = std::filesystem::temp_directory_path() / "run_log_odometry_test";
  std::filesystem::remove_all(folder);
  PipelineParams with_height = streetParams();
  with_height.experience_map.exp_height = true;  // the map then takes displacements from the poses
  Pipeline first(with_height,
                 std::make_unique<ProfileSource>(with_height.odometry.of<ProfileOdometryParams>()));
  RunLog log(folder.string());
  for (int frame = 0; frame < kFrames; ++frame)
    log.append(first.addImage({frame * kTenth, view(frame)}), first.map());
  log.finish(first, with_height, {});
  const auto samples = readOdometryCsv((folder / "odometry.csv").string());
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(kFrames));
  Pipeline second(with_height, {});
  for (int frame = 0; frame < kFrames; ++frame) {
    second.addOdometry(samples[static_cast<std::size_t>(frame)]);
    second.addImage({frame * kTenth, view(frame)});
  }
  EXPECT_EQ(describe(second.map()), describe(first.map()));
  std::filesystem::remove_all(folder);
}

TEST(PipelineParams, EveryModelsKeysAreKnownOnce) {
  PipelineParams p;
  std::set<std::string> seen;
  p.visitFields([&seen](const std::string& key, auto&, const Bounds&, const char* meaning) {
    EXPECT_TRUE(seen.insert(key).second) << key << " has two meanings";
    EXPECT_STRNE(meaning, "") << key;
  });
  EXPECT_EQ(seen, PipelineParams::knownKeys());
}

TEST(RunLog, LeavesTheStatedFiles) {
  const auto folder = std::filesystem::temp_directory_path() / "run_log_test";
  std::filesystem::remove_all(folder);
  Pipeline pipeline(streetParams(), {});
  RunLog log(folder.string());
  for (int frame = 0; frame < 50; ++frame) {
    log.append(pipeline.addOdometry(motion(frame, 0.1)), pipeline.map());
    log.append(pipeline.addImage({frame * kTenth, view(frame)}), pipeline.map());
  }
  log.finish(pipeline, streetParams(), {{"frames", 50.0}});
  const auto lines = [&folder](const std::string& name) {
    std::ifstream file(folder / name);
    return std::count(std::istreambuf_iterator<char>(file), {}, '\n');
  };
  EXPECT_EQ(lines("templates.csv"), 51);
  EXPECT_EQ(lines("actions.csv"), 51);
  EXPECT_EQ(lines("pose_covariance.csv"), 50);  // none before the first place
  EXPECT_EQ(lines("trajectory_online.tum"), 50);
  EXPECT_EQ(lines("trajectory_final.tum"), 50);
  EXPECT_GT(lines("map.yaml"), 10);
  EXPECT_GT(lines("summary.json"), 30);
  std::filesystem::remove_all(folder);
}

/// Dead reckoning to the end of the map says nothing of where the next drive begins: it excludes no place there.
TEST(Pipeline, AnotherDriveInTheSameMapStartsDeadReckoningAnew) {
  const auto epoch = [](const State& state) {
    return state.child("local_view").child("streams").get<std::uint32_t>("epoch");
  };
  State mapped;
  Pipeline(streetParams(), {}).save(mapped);
  for (const bool go_on : {true, false}) {
    Pipeline pipeline(streetParams(), {});
    pipeline.load(mapped, go_on);
    State loaded;
    pipeline.save(loaded);
    EXPECT_EQ(epoch(loaded) == epoch(mapped), go_on);
  }
}

}  // namespace
}  // namespace ratslam
