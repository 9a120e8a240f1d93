/// Waking up: the robot goes on from an unknown position, most likely among the learned places.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "ratslam/common/state.h"
#include "ratslam/local_view/local_view_cells.h"

namespace ratslam {
namespace {

constexpr int kPlaces = 60;  // learned 1 m apart; the robot parks at the last one
constexpr int kNowhere = -1;

/// A place's look, another one for each number.
cv::Mat look(int place) {
  cv::RNG random(static_cast<std::uint64_t>(place) + 1);
  cv::Mat blocks(16, 32, CV_8UC1);
  random.fill(blocks, cv::RNG::UNIFORM, 0, 255);
  cv::Mat image;
  cv::resize(blocks, image, cv::Size(128, 64), 0, 0, cv::INTER_NEAREST);
  return image;
}

/// A look to which another one adds a share of its own.
cv::Mat mixed(int place, int other, double share) {
  cv::Mat image;
  cv::addWeighted(look(place), 1.0 - share, look(other), share, 0.0, image);
  return image;
}

struct Verifier : RecallVerifier {
  explicit Verifier(bool confirms_all) : confirms(confirms_all) {}
  std::optional<RecallGeometry> verify(Stamp, const cv::Mat&, std::uint32_t id) override {
    asked.push_back(id);
    if (!confirms) return std::nullopt;
    return RecallGeometry{};
  }
  void learned(Stamp, const cv::Mat&, std::uint32_t) override {}

  bool confirms;
  std::vector<std::uint32_t> asked;
};

/// A robot that has parked at the last of its places and wakes up somewhere.
class Sleeper {
 public:
  explicit Sleeper(const char* recall, bool loaded = false) {
    params_.descriptor = "orientation";
    params_.recall.kind = recall;
    cells_ = std::make_unique<LocalViewCells>(params_);
    for (int place = 0; place < kPlaces; ++place) see(look(place), 1.0);
    if (loaded) reload();
    cells_->wakeUp();
    ++epoch_;
  }

  /// Saves the cells and goes on with new ones.
  void reload() {
    State state;
    cells_->save(state);
    cells_ = std::make_unique<LocalViewCells>(params_);
    cells_->load(State::fromBytes(state.toBytes()));
  }

  ViewEvent see(const cv::Mat& image, double forward, RecallVerifier* verifier = nullptr) {
    ViewMotion motion;
    motion.forward = forward;
    motion.forward_variance = 1e-4;
    motion.yaw_variance = 1e-6;
    motion.epoch = epoch_;
    return cells_->observe(++stamp_, cells_->describe(image), image, motion, verifier);
  }

  /// Number of views until the first recall, from a place on to the last one, and there in looks that change a little.
  int viewsUntilFound(int start) {
    cells_->setLearning(false);
    for (int views = 1; views <= kPlaces; ++views) {
      const int beyond = std::max(start + views - kPlaces, 0);
      const int place = start + views - 1 - beyond;
      const cv::Mat image = mixed(place, 1000 + beyond, beyond > 0 ? 0.3 : 0.0);
      const ViewEvent event = see(image, views > 1 && beyond == 0 ? 1.0 : 0.0);
      if (!event.seen()) continue;
      EXPECT_NEAR(static_cast<int>(event.id), place, 2) << "from " << start;
      return views;
    }
    return kNowhere;
  }

 private:
  LocalViewParams params_;
  std::unique_ptr<LocalViewCells> cells_;
  std::uint32_t epoch_ = 0;
  Stamp stamp_ = 0;
};

/// Also among the places learned last, and at the dock, the very last one.
TEST(WakingUp, FindsEveryPlaceEquallySoon) {
  for (const bool loaded : {false, true}) {
    const int views = Sleeper("belief", loaded).viewsUntilFound(20);
    ASSERT_GT(views, 1) << "one view is too little";
    ASSERT_LE(views, 3);
    for (int start = 0; start < kPlaces; ++start) {
      const int found = Sleeper("belief", loaded).viewsUntilFound(start);
      EXPECT_GT(found, 1) << start;
      EXPECT_LE(found, views + 1) << start;
    }
  }
}

TEST(WakingUp, NeedsMoreThanOneSimilarViewAtAnyPlace) {
  for (const int place : {30, kPlaces - 5, kPlaces - 1}) {
    for (const double own : {0.1, 0.15}) {
      EXPECT_TRUE(Sleeper("belief").see(mixed(place, 777, own), 0.0).learned) << place << ' ' << own;
    }
  }
}

/// The robot need not be where it was, so that a recall may be a chance match with a distant place.
TEST(WakingUp, HasTheFirstRecallVerifiedAtAnyPlace) {
  for (const int place : {30, kPlaces - 5, kPlaces - 1}) {
    for (const bool saved : {false, true}) {
      Sleeper robot("nearest");
      if (saved) robot.reload();
      Verifier verifier(false);
      const cv::Mat image = mixed(place, 777, 0.1);
      EXPECT_TRUE(robot.see(image, 0.0, &verifier).learned) << place;
      EXPECT_EQ(verifier.asked, std::vector<std::uint32_t>{static_cast<std::uint32_t>(place)});
      EXPECT_EQ(robot.see(image, 0.0, &verifier).id, kPlaces) << "it stays where it has learned a place";
      EXPECT_EQ(verifier.asked.size(), 1U);
    }
  }
}

TEST(WakingUp, AConfirmedPlaceIsWhereTheRobotIs) {
  Sleeper robot("nearest");
  Verifier verifier(true);
  EXPECT_EQ(robot.see(look(kPlaces - 1), 0.0, &verifier).id, kPlaces - 1U);
  EXPECT_EQ(verifier.asked.size(), 1U);
  EXPECT_EQ(robot.see(look(kPlaces - 1), 0.0, &verifier).id, kPlaces - 1U);
  EXPECT_EQ(verifier.asked.size(), 1U);
}

}  // namespace
}  // namespace ratslam
