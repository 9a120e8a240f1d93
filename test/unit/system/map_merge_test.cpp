/// What a merge of two maps keeps: where views were seen, how well a motion is known, and that a drive counts once.
#include "ratslam/system/map_merge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "ratslam/experience_map/solver/pose_graph.h"
#include "ratslam/system/pipeline.h"
#include "unit/message_of.h"

namespace ratslam {
namespace {

/// A view of a street at each metre along it: blocks of random grey.
cv::Mat viewAt(int metre, int darkest = 30, int brightest = 226) {
  cv::RNG random(static_cast<std::uint64_t>(1000 + metre) * 7919);
  cv::Mat blocks(10, 60, CV_8UC1);
  random.fill(blocks, cv::RNG::UNIFORM, darkest, brightest);
  cv::Mat image;
  cv::resize(blocks, image, cv::Size(240, 40), 0.0, 0.0, cv::INTER_NEAREST);
  return image;
}

PipelineParams streetParams() {
  PipelineParams params;
  params.local_view.view_template.x_size = 60;
  params.local_view.view_template.y_size = 10;
  params.local_view.match_threshold = 0.085;
  params.local_view.step_match = 1;
  params.pose_cells.n_xy = 30;
  params.experience_map.exp_initial_em_deg = 0.0;
  return params;
}

/// A drive along the street, and the map that it makes.
class Drive {
 public:
  explicit Drive(Stamp begin, const PipelineParams& params = streetParams())
      : params_(params), pipeline_(params, {}), first_(begin), now_(begin) {}

  /// Drives at 5 m/s and sees the street from one metre to another.
  void see(int first, int last) {
    for (int metre = first; metre != last; metre += first < last ? 1 : -1) {
      step(metre, viewAt(metre), nothing_yet_ ? 0.0 : 5.0);
    }
  }
  /// No odometry comes while the robot goes on. The sample after it states the speed of its moment.
  /// @param moved  by the odometry's poses [m]
  void beSilent(double seconds, double moved = 0.0) {
    now_ += stampFromSeconds(seconds - kPeriod);
    x_ += moved;
  }
  /// From now on the odometry states poses.
  void statePoses() { with_poses_ = true; }
  /// The camera sees nothing. @param predicted  whether the odometry predicts instead of measuring
  void goDark(int metres, double speed, bool predicted) {
    for (int k = 0; k < metres; ++k) step(-1, cv::Mat(40, 240, CV_8UC1, cv::Scalar(0)), speed, predicted);
  }
  void step(int metre, const cv::Mat& image, double speed, bool predicted = false, double yaw_rate = 0.0) {
    if (!nothing_yet_) now_ += stampFromSeconds(kPeriod);
    nothing_yet_ = false;
    OdometrySample sample;
    sample.stamp = now_;
    sample.speed = speed;
    sample.yaw_rate = yaw_rate;
    sample.bridged = predicted;
    x_ += speed * kPeriod;
    if (with_poses_) sample.pose = Eigen::Isometry3d(Eigen::Translation3d(x_, 0.0, 0.0));
    pipeline_.addOdometry(sample);
    pipeline_.addImage({now_, image});
    if (metre >= 0) stamp_at_[metre] = now_;
  }
  /// The motion until the next view is unknown.
  void beCarried() {
    pipeline_.interrupt();
    now_ += stampFromSeconds(5.0);
  }

  MapCheckpoint map() const {
    MapCheckpoint map;
    map.stamp = now_;
    map.parameters = parameterTexts(params_);
    map.sessions = {{"test", first_, now_}};
    pipeline_.save(map.state);
    return map;
  }
  Stamp stampAt(int metre) const { return stamp_at_.at(metre); }

  static constexpr double kPeriod = 0.2;  // [s]

 private:
  PipelineParams params_;
  Pipeline pipeline_;
  std::map<int, Stamp> stamp_at_;
  Stamp first_;
  Stamp now_;
  double x_ = 0.0;  ///< of the odometry's pose [m]
  bool with_poses_ = false;
  bool nothing_yet_ = true;
};

constexpr Stamp kLater = 1'000'000'000'000;

ExperienceMap experiencesOf(const MapCheckpoint& map, const PipelineParams& params = streetParams()) {
  ExperienceMap experiences(params.experience_map);
  experiences.load(map.state.child("experience_map").child("map"));
  experiences.settle();
  return experiences;
}

double distance(const MapPose& a, const MapPose& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// Where the robot was at a stamp.
MapPose poseAt(const ExperienceMap& map, Stamp stamp) {
  for (const StampedPose& pose : map.finalTrajectory()) {
    if (pose.stamp == stamp) return pose.pose;
  }
  ADD_FAILURE() << "the path has no pose at " << stamp;
  return {};
}

/// The largest distance of an experience from the first one with the same view.
double farthestView(const MapCheckpoint& map, const PipelineParams& params) {
  PoseCellStage cells(params.pose_cells);
  cells.load(map.state.child("pose_cells"));
  const ExperienceMap experiences = experiencesOf(map, params);
  std::map<std::uint32_t, std::uint32_t> first_of_view;
  double farthest = 0.0;
  for (std::uint32_t id = 0; id < experiences.graph().experiences().size(); ++id) {
    const auto view = cells.cells().viewOf(id);
    if (!view) continue;
    const std::uint32_t first = first_of_view.try_emplace(view->view_id, id).first->second;
    farthest = std::max(farthest, distance(experiences.graph().pose(id), experiences.graph().pose(first)));
  }
  return farthest;
}

/// Standard deviation of the place, along the way, of the constraint that covers a stamp of the path.
double sigmaOver(const MapCheckpoint& map, Stamp stamp) {
  const State& saved = map.state.child("experience_map").child("map");
  Trajectory trajectory;
  saved.get("trajectory", trajectory);
  const auto& samples = trajectory.samples();
  std::size_t k = 1;
  while (k < samples.size() && samples[k].stamp < stamp) ++k;
  for (const Constraint& way :
       saved.child("solver").child("graph").get<std::vector<Constraint>>("constraints")) {
    if (!way.closes() && way.from == samples.at(k - 1).frame && way.to == samples.at(k).frame)
      return std::sqrt(covarianceOf(way)(0, 0));
  }
  return 0.0;
}

/// Both orders must give the same bytes.
MapMerge mergeInBothOrders(const MapCheckpoint& a, const MapCheckpoint& b) {
  MapMerge merged = mergeMaps(a, b);
  EXPECT_TRUE(merged.map.state.toBytes() == mergeMaps(b, a).map.state.toBytes());
  return merged;
}

TEST(MapMerge, KeepsNormalisedViewsWithLamps) {
  PipelineParams params = streetParams();
  params.local_view.view_template.normalisation = 0.4;
  const auto street = [](int metre) {
    cv::Mat view = viewAt(metre, 2, 22);
    cv::RNG random(static_cast<std::uint64_t>(metre));
    for (int k = 0; k < 4; ++k)
      view(cv::Rect(4 * random.uniform(0, 55), 4 * random.uniform(0, 8), 20, 8)).setTo(250);
    return view;
  };
  Drive first(0, params), second(kLater, params);
  for (int metre = 0; metre < 20; ++metre) first.step(metre, street(metre), metre == 0 ? 0.0 : 5.0);
  for (int metre = 100; metre < 120; ++metre) second.step(metre, street(metre), metre == 100 ? 0.0 : 5.0);
  const MapMerge merged = mergeInBothOrders(first.map(), second.map());
  LocalViewCells cells(params.local_view);
  cells.load(merged.map.state.child("local_view"));
  cells.setLearning(false);
  for (const int metre : {1, 10, 19, 101, 110, 119})
    EXPECT_TRUE(cells.observe(kLater * 2 + metre, street(metre)).seen()) << metre;
}

TEST(MapMerge, ASilentStretchStaysAsLooseAsItWas) {
  Drive first(0), second(kLater);
  first.see(0, 100);
  second.see(10, 40);
  second.beSilent(5.2);
  second.see(65, 95);
  const MapMerge merged = mergeInBothOrders(first.map(), second.map());
  EXPECT_EQ(merged.components, 1U);
  const ExperienceMap map = experiencesOf(merged.map);
  for (const int metre : {15, 39, 65, 66, 80, 94}) {
    EXPECT_LT(distance(poseAt(map, first.stampAt(metre)), poseAt(map, second.stampAt(metre))), 1.0) << metre;
  }
}

TEST(MapMerge, ASilentStretchIntoTheUnknownKeepsItsUncertainty) {
  for (const double seconds : {5.2, 60.0}) {
    for (const int unseen : {0, 1}) {  // metres driven after the silence before a view is seen
      Drive first(0), second(kLater);
      first.see(0, 100);
      second.see(10, 40);
      second.beSilent(seconds);
      second.goDark(unseen, 5.0, false);
      second.see(165, 195);
      const MapCheckpoint alone = second.map();
      const MapMerge merged = mergeInBothOrders(first.map(), alone);
      EXPECT_EQ(merged.components, 1U) << "the loose link still joins the stretch";
      const double before = sigmaOver(alone, second.stampAt(165));
      const double after = sigmaOver(merged.map, second.stampAt(165));
      EXPECT_GT(before, 10.0);
      EXPECT_NEAR(after, before, 0.1 * before) << seconds << " s, " << unseen << " m";
    }
  }
}

TEST(MapMerge, ASilentStretchBetweenTwoPosesKeepsItsUncertainty) {
  Drive first(0), second(kLater);
  first.see(0, 100);
  second.statePoses();
  second.see(110, 140);
  second.beSilent(600.0, 25.0);
  second.see(165, 195);
  const MapCheckpoint alone = second.map();
  const MapMerge merged = mergeInBothOrders(first.map(), alone);
  const double before = sigmaOver(alone, second.stampAt(165));
  EXPECT_GT(before, 1000.0);
  EXPECT_NEAR(sigmaOver(merged.map, second.stampAt(165)), before, 0.1 * before);
  const ExperienceMap map = experiencesOf(merged.map);
  EXPECT_NEAR(distance(poseAt(map, second.stampAt(139)), poseAt(map, second.stampAt(165))), 26.0, 1.5);
}

TEST(MapMerge, APredictedStandstillKeepsItsUncertainty) {
  Drive first(0), second(kLater);
  first.see(0, 100);
  second.see(10, 40);
  second.goDark(600, 0.0, true);
  second.see(165, 195);
  const MapCheckpoint alone = second.map();
  const MapMerge merged = mergeInBothOrders(first.map(), alone);
  const double before = sigmaOver(alone, second.stampAt(165));
  EXPECT_GT(before, 10.0);
  EXPECT_NEAR(sigmaOver(merged.map, second.stampAt(165)), before, 0.1 * before);
}

TEST(MapMerge, AMotionUnknownToTheMapIsNotMadeUp) {
  Drive first(0), second(kLater);
  first.see(0, 100);
  second.see(20, 40);
  second.beCarried();
  // From another heading it turns to the street, and comes back to where it was.
  for (int k = 0; k < 10; ++k)
    second.step(300 + k, viewAt(300 + k), 0.0, false, k == 0 ? 0.0 : kPi / 18.0 / Drive::kPeriod);
  for (int metre = 94; metre > 30; --metre) second.step(metre, viewAt(metre), -5.0);
  const MapCheckpoint alone = second.map();
  const MapMerge merged = mergeInBothOrders(first.map(), alone);
  EXPECT_EQ(merged.components, 1U);
  const ExperienceMap map = experiencesOf(merged.map);
  for (const int metre : {93, 75, 60, 41}) {
    EXPECT_LT(distance(poseAt(map, first.stampAt(metre)), poseAt(map, second.stampAt(metre))), 1.0) << metre;
  }
  const Stamp put_down = second.stampAt(300);
  EXPECT_GT(sigmaOver(alone, put_down), 100.0);
  EXPECT_NEAR(sigmaOver(merged.map, put_down) / sigmaOver(alone, put_down), 1.0, 0.5);
}

/// Drives to and fro through a street that is seen all round.
MapCheckpoint panoramicDrive(Stamp begin, int first, int length, bool back, const PipelineParams& params) {
  Drive drive(begin, params);
  const auto look = [&](double x, double heading) {
    const int near = static_cast<int>(std::floor(x));
    cv::Mat blend, turned;
    cv::addWeighted(viewAt(first + near, 0, 256), 1.0 - (x - near), viewAt(first + near + 1, 0, 256),
                    x - near, 0.0, blend);
    const int shift = static_cast<int>(std::lround(heading / (2.0 * kPi) * 60)) * 4;
    cv::repeat(blend, 1, 2, turned);
    return turned.colRange(240 - shift, 480 - shift).clone();
  };
  double x = 0.0;
  drive.step(-1, look(x, 0.0), 0.0);
  for (int k = 0; k < 2 * length; ++k) drive.step(-1, look(x += 0.5, 0.0), 0.5 / Drive::kPeriod);
  for (int k = 1; back && k <= 10; ++k)
    drive.step(-1, look(x, k * kPi / 10), 0.0, false, kPi / 10 / Drive::kPeriod);
  for (int k = 0; back && k < 2 * length; ++k) drive.step(-1, look(x -= 0.5, kPi), 0.5 / Drive::kPeriod);
  return drive.map();
}

TEST(MapMerge, ShowsARecalledPanoramaWhereItWasRecalled) {
  PipelineParams params = streetParams();
  params.local_view.panoramic = true;
  params.local_view.match_threshold = 0.08;
  const MapCheckpoint alone = panoramicDrive(kLater, 100, 40, true, params);
  const MapMerge merged = mergeInBothOrders(panoramicDrive(0, 500, 40, false, params), alone);
  EXPECT_EQ(merged.components, 2U);
  EXPECT_LE(farthestView(merged.map, params), farthestView(alone, params) + 3.0);
}

class DarkStretch : public testing::TestWithParam<bool> {};

TEST_P(DarkStretch, ShowsNothing) {
  Drive first(0), second(kLater);
  first.see(200, 260);
  second.see(0, 40);
  second.goDark(40, 5.0, GetParam());
  second.see(80, 120);
  const MapMerge merged = mergeInBothOrders(first.map(), second.map());
  EXPECT_EQ(merged.components, 2U);
  EXPECT_LE(farthestView(merged.map, streetParams()), 3.0);
  EXPECT_EQ(merged.experiences, merged.first_experiences + merged.second_experiences);
}

INSTANTIATE_TEST_SUITE_P(WithAndWithoutPrediction, DarkStretch, testing::Bool());

TEST(MapMerge, ADriveIsMergedOnce) {
  Drive first(0), second(kLater), third(2 * kLater);
  first.see(0, 30);
  second.see(100, 130);
  third.see(200, 230);
  const MapCheckpoint both = mergeMaps(first.map(), second.map()).map;
  const MapCheckpoint others = mergeMaps(second.map(), third.map()).map;
  for (const MapCheckpoint& again : {first.map(), second.map(), others}) {
    for (const bool swapped : {false, true}) {
      const std::string complaint =
          test::messageOf([&] { swapped ? mergeMaps(again, both) : mergeMaps(both, again); });
      EXPECT_NE(complaint.find("different drives"), std::string::npos) << complaint;
    }
  }
  EXPECT_EQ(mergeInBothOrders(both, third.map()).components, 3U);
}

TEST(MapMerge, DrivesThatBeganAtTheSameTimeAreTwo) {
  Drive first(0), second(0);  // of two recordings whose stamps begin with 0
  first.see(0, 30);
  second.see(100, 130);
  EXPECT_EQ(mergeInBothOrders(first.map(), second.map()).components, 2U);
}

}  // namespace
}  // namespace ratslam
