#include "ratslam_ros/support/message_guard.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "ratslam_ros/support/conversions.h"

namespace ratslam {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(MessageGuard, CountsWhatWasDroppedByTopicAndGoesOn) {
  MessageGuard guard;
  int processed = 0;
  for (int i = 0; i < 5; ++i) {
    guard.run("/odom", [&] {
      if (i % 2 == 0) throw std::runtime_error("not this one");
      ++processed;
    });
  }
  EXPECT_TRUE(guard.run("/view", [] {}));
  EXPECT_EQ(processed, 2);
  EXPECT_EQ(guard.dropped("/odom"), 3U);
  EXPECT_EQ(guard.dropped("/view"), 0U);
}

TEST(MessageGuard, CountsWhatNeverCameByTheNumbersOfEachPublisher) {
  MessageGuard guard;
  guard.number("/view", "/lv", 7);  // whatever went before it joined
  guard.number("/view", "/lv", 8);
  EXPECT_EQ(guard.lost("/view"), 0U);
  guard.number("/view", "/lv", 20);
  guard.number("/view", "/other", 500);
  guard.number("/view", "/lv", 21);
  EXPECT_EQ(guard.lost("/view"), 11U);
  guard.number("/view", "/lv", 0);  // it was started again
  guard.number("/view", "/lv", 1);
  guard.number("/odom", "/nodelet", 0);  // within a process nobody counts
  guard.number("/odom", "/nodelet", 0);
  EXPECT_EQ(guard.lost("/view"), 11U);
  EXPECT_EQ(guard.lost("/odom"), 0U);
}

TEST(Conversions, NumbersThatAreNotFiniteAreRefused) {
  ratslam_ros::ViewTemplate view;
  view.relative_rad = kNaN;
  EXPECT_THROW(viewFromMessage(view), std::runtime_error);
  ratslam_ros::TopologicalAction action;
  action.action = 1;
  action.relative_rad = std::numeric_limits<double>::infinity();
  EXPECT_THROW(actionFromMessage(action), std::runtime_error);
  ratslam_ros::RecallGeometry geometry;
  geometry.distance = kNaN;
  EXPECT_NO_THROW(geometryFromMessage(geometry)) << "nothing was measured";
  geometry.inliers = 30;
  EXPECT_THROW(geometryFromMessage(geometry), std::runtime_error);
}

}  // namespace
}  // namespace ratslam
