/// Every stage that is saved, loaded and continued ends in the same bits as one that was never interrupted.
#include "ratslam/common/state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "ratslam/local_view/local_view_cells.h"
#include "ratslam/odometry/profile/profile_odometry.h"
#include "ratslam/system/map_stage.h"
#include "ratslam/system/pose_cell_stage.h"

namespace ratslam {
namespace {

/// What the streams of a drive bring at one time.
struct Tick {
  OdometrySample odometry;
  std::optional<ViewEvent> view;
};

/// Laps of a loop: views are learned on the first and mostly recalled on the others, with odometry that
/// drifts, so that the solver has something to do.
std::vector<Tick> drive(std::size_t ticks) {
  constexpr std::uint32_t kViewsALap = 60;
  std::mt19937 random(5);
  const auto noise = [&random] { return (static_cast<double>(random() % 2001) - 1000.0) / 1000.0; };
  std::vector<Tick> drive;
  std::uint32_t learned = 0;
  std::uint32_t view_number = 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < ticks; ++i) {
    Tick tick;
    tick.odometry.stamp = static_cast<Stamp>(i + 1) * 100'000'000;
    tick.odometry.speed = 8.0 + 0.8 * noise();
    tick.odometry.yaw_rate = 2.0 * M_PI / (0.2 * kViewsALap) * (1.0 + 0.1 * noise());
    pose.rotate(Eigen::AngleAxisd(0.1 * tick.odometry.yaw_rate, Eigen::Vector3d::UnitZ()));
    pose.translate(Eigen::Vector3d(0.1 * tick.odometry.speed, 0.0, 0.01 * noise()));
    tick.odometry.pose = pose;
    if (i % 2 == 1) {
      ViewEvent view;
      view.stamp = tick.odometry.stamp - 30'000'000;
      const std::uint32_t place = view_number++ % kViewsALap;
      view.learned = view_number <= kViewsALap || random() % 9 == 0;
      view.id = view.learned ? learned++ : place;
      view.relative_rad = view.learned ? 0.0 : 0.02 * noise();
      tick.view = view;
    }
    drive.push_back(tick);
  }
  return drive;
}

/// Pose cells and map fed as the pipeline feeds them.
class Chain {
 public:
  Chain(const PoseCellParams& pose_cells, const ExperienceMapParams& map, bool geometry)
      : cells_(pose_cells),
        map_(map, geometry ? GeometrySource::kImages : GeometrySource::kNone),
        geometry_(geometry) {}

  void feed(const Tick& tick) {
    cells_.addOdometry(tick.odometry);
    map_.addOdometry(tick.odometry);
    if (tick.view) {
      cells_.addView(*tick.view);
      if (geometry_) {
        RecallGeometry measured;
        measured.stamp = tick.view->stamp;
        measured.view_id = tick.view->id;
        measured.inliers = tick.view->id % 3 == 0 && !tick.view->learned ? 50 : 0;
        measured.distance = 0.3;
        if (measured.inliers == 0) measured.ahead = -0.2;
        map_.addGeometry(measured);
      }
    }
    for (const PoseCellDecision& decision : cells_.drain()) map_.addDecision(decision.action);
    map_.drain();
  }

  State state() const {
    State state;
    cells_.save(state.child("pose_cells"));
    map_.save(state.child("experience_map"));
    return state;
  }
  void load(const State& state) {
    cells_.load(state.child("pose_cells"));
    map_.load(state.child("experience_map"));
  }
  const ExperienceMap& map() const { return map_.map(); }

 private:
  PoseCellStage cells_;
  MapStage map_;
  bool geometry_;
};

struct Setting {
  const char* name;
  const char* solver;
  bool scale;
  bool height;
  bool geometry;
};

class Continued : public testing::TestWithParam<Setting> {
 protected:
  static Chain chain() {
    PoseCellParams cells;
    cells.n_xy = 30;
    ExperienceMapParams map;
    map.exp_solver = GetParam().solver;
    map.exp_scale = GetParam().scale;
    map.exp_height = GetParam().height;
    return Chain(cells, map, GetParam().geometry);
  }
};

TEST_P(Continued, EndsInTheSameBits) {
  const std::vector<Tick> ticks = drive(900);
  Chain whole = chain();
  std::vector<std::vector<std::uint8_t>> saved;
  std::vector<State> taken;
  const std::vector<std::size_t> stops{0, 1, 2, 57, 333, 501, 502, 503, 777, 898};
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    if (std::count(stops.begin(), stops.end(), i) > 0) {
      saved.push_back(whole.state().toBytes());
      taken.push_back(whole.state());
    }
    whole.feed(ticks[i]);
  }
  for (std::size_t k = 0; k < stops.size(); ++k)
    EXPECT_TRUE(taken[k].toBytes() == saved[k]) << "looked at later, taken after " << stops[k];
  ASSERT_GT(whole.map().graph().links().size(), whole.map().graph().experiences().size());
  const State end = whole.state();
  for (std::size_t k = 0; k < stops.size(); ++k) {
    Chain continued = chain();
    continued.load(State::fromBytes(saved[k]));
    EXPECT_TRUE(continued.state().toBytes() == saved[k]) << "saved again after " << stops[k];
    for (std::size_t i = stops[k]; i < ticks.size(); ++i) continued.feed(ticks[i]);
    EXPECT_TRUE(continued.state() == end) << "continued after " << stops[k];
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, Continued,
                         testing::Values(Setting{"graph", "graph", false, false, false},
                                         Setting{"scale", "graph", true, true, false},
                                         Setting{"geometry", "graph", true, false, true},
                                         Setting{"relaxation", "relaxation", false, false, false}),
                         [](const auto& setting) { return setting.param.name; });

TEST(Stage, SavingDoesNotDisturb) {
  const std::vector<Tick> ticks = drive(600);
  PoseCellParams cells;
  Chain undisturbed(cells, {}, false);
  Chain saved(cells, {}, false);
  for (const Tick& tick : ticks) {
    undisturbed.feed(tick);
    saved.feed(tick);
    saved.state();
  }
  EXPECT_TRUE(undisturbed.state() == saved.state());
}

TEST(Stage, RefusesPoseCellsOfAnotherSize) {
  PoseCellParams params;
  State state;
  PoseCellStage(params).save(state);
  params.n_xy = 30;
  EXPECT_THROW(PoseCellStage(params).load(state), std::runtime_error);
}

std::vector<cv::Mat> noiseImages(int count) {
  std::mt19937 random(7);
  std::vector<cv::Mat> images;
  for (int i = 0; i < count; ++i) {
    cv::Mat image(30, 120, CV_8U);
    for (auto pixel = image.begin<std::uint8_t>(); pixel != image.end<std::uint8_t>(); ++pixel) {
      *pixel = static_cast<std::uint8_t>(random());
    }
    images.push_back(image);
  }
  return images;
}

TEST(Stage, LocalViewCells) {
  const std::vector<cv::Mat> images = noiseImages(40);
  for (const int radius : {0, 1}) {
    LocalViewParams params;
    params.view_template.x_size = 32;
    params.view_template.y_size = 8;
    params.view_template.patch_radius = radius;
    params.view_template.normalisation = radius == 0 ? 0.4 : 0.0;
    params.shift_match = 3;
    params.step_match = 1;
    LocalViewCells whole(params);
    LocalViewCells continued(params);
    const std::size_t frames = 3 * images.size();
    const std::size_t stop = 33;
    for (std::size_t i = 0; i < frames; ++i) {
      if (i == stop) {
        State state;
        whole.save(state);
        continued.load(State::fromBytes(state.toBytes()));
      }
      const cv::Mat& image = images[i * i % images.size()];
      const ViewEvent of_whole = whole.observe(static_cast<Stamp>(i), image);
      if (i < stop) continue;
      const ViewEvent of_continued = continued.observe(static_cast<Stamp>(i), image);
      EXPECT_EQ(of_whole.id, of_continued.id);
      EXPECT_EQ(of_whole.error, of_continued.error);
    }
    State of_whole;
    State of_continued;
    whole.save(of_whole);
    continued.save(of_continued);
    EXPECT_TRUE(of_whole == of_continued);
  }
}

TEST(Stage, ProfileOdometry) {
  const std::vector<cv::Mat> images = noiseImages(12);
  ProfileOdometry whole{ProfileOdometryParams{}};
  ProfileOdometry continued{ProfileOdometryParams{}};
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Stamp stamp = static_cast<Stamp>(i) * 50'000'000;
    if (i == 5) {
      State state;
      whole.save(state);
      continued.load(state);
    }
    whole.track(stamp, images[i]);
    if (i >= 5) continued.track(stamp, images[i]);
  }
  State of_whole;
  State of_continued;
  whole.save(of_whole);
  continued.save(of_continued);
  EXPECT_TRUE(of_whole == of_continued);
}

}  // namespace
}  // namespace ratslam
