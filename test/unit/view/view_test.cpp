// Pictures are looked at by people; what is tested here is that they show the right thing in the right place.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <vector>

#include "ratslam/view/canvas.h"
#include "ratslam/view/composite.h"
#include "ratslam/view/draw_activity.h"
#include "ratslam/view/draw_local_view.h"
#include "ratslam/view/draw_map.h"

namespace ratslam {
namespace {

constexpr int kPanelHeight = 298;  // of the activity's three panels at 600 x 600

/// Centre of the pixels of about that colour; how many there are.
std::pair<cv::Point2d, int> centreOf(const cv::Mat& picture, const cv::Scalar& colour) {
  cv::Mat mask;
  cv::inRange(picture, colour - cv::Scalar::all(12), colour + cv::Scalar::all(12), mask);
  const cv::Moments moments = cv::moments(mask, true);
  return {{moments.m10 / std::max(1.0, moments.m00), moments.m01 / std::max(1.0, moments.m00)},
          cv::countNonZero(mask)};
}

/// Centre of the pixels in which one channel clearly outshines another, below the lettering; how many there
/// are.
std::pair<cv::Point2d, int> centreWhere(const cv::Mat& picture, int channel, int other) {
  cv::Mat bright;
  cv::Mat dark;
  cv::extractChannel(picture, bright, channel);
  cv::extractChannel(picture, dark, other);
  cv::Mat difference;
  cv::subtract(bright, dark, difference);
  const cv::Mat mask = difference > 60;
  const cv::Moments moments = cv::moments(mask, true);
  return {{moments.m10 / std::max(1.0, moments.m00), moments.m01 / std::max(1.0, moments.m00)},
          cv::countNonZero(mask)};
}

/// The brightest place of a part of a picture.
cv::Point brightest(const cv::Mat& picture, const cv::Rect& part) {
  cv::Mat grey;
  cv::cvtColor(picture(part), grey, cv::COLOR_BGR2GRAY);
  cv::rectangle(grey, {0, 0, 150, 30}, cv::Scalar(0), cv::FILLED);  // lettering
  cv::blur(grey, grey, {5, 5});
  cv::Point place;
  cv::minMaxLoc(grey, nullptr, nullptr, nullptr, &place);
  return place;
}

TEST(Canvas, TakesEveryKindOfImageTheSystemTakes) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1}) {
    const cv::Mat image(6, 8, type, cv::Scalar::all(type == CV_16UC1 ? 100 * 257 : 100));
    const cv::Mat converted = toBgr8(image);
    EXPECT_EQ(converted.type(), CV_8UC3);
    EXPECT_EQ(converted.at<cv::Vec3b>(3, 3), cv::Vec3b(100, 100, 100)) << type;
  }
  EXPECT_THROW(toBgr8(cv::Mat()), std::invalid_argument);
  EXPECT_THROW(toBgr8(cv::Mat(4, 4, CV_32FC1)), std::invalid_argument);
}

TEST(Canvas, FitsWithoutDistortingOrOverflowing) {
  const cv::Mat wide(10, 1000, CV_8UC3, cv::Scalar::all(255));
  const cv::Mat fitted = fitInto(wide, {200, 300}, cv::INTER_AREA);
  EXPECT_EQ(fitted.size(), cv::Size(200, 300));
  EXPECT_NEAR(centreOf(fitted, cv::Scalar::all(255)).second, 200 * 2, 200);
  EXPECT_EQ(fitInto(cv::Mat(1000, 1, CV_8UC3), {3, 3}, cv::INTER_AREA).size(), cv::Size(3, 3));
}

TEST(LocalViewPicture, ShowsViewAtTheLeftAndTemplateAtTheRight) {
  ViewEvent view;
  view.id = 12;
  view.error = 0.02;
  const cv::Mat camera(60, 160, CV_8UC1, cv::Scalar(50));
  const cv::Mat present(10, 20, CV_8UC1, cv::Scalar(200));
  const cv::Mat stored(10, 20, CV_8UC1, cv::Scalar(120));
  const cv::Mat picture = drawLocalView(camera, view, present, stored, {600, 400});
  EXPECT_EQ(picture.size(), cv::Size(600, 400));
  const auto left = centreOf(picture, cv::Scalar::all(200));
  const auto right = centreOf(picture, cv::Scalar::all(120));
  EXPECT_GT(left.second, 10000);
  EXPECT_GT(right.second, 10000);
  EXPECT_LT(left.first.x, 300);
  EXPECT_GT(right.first.x, 300);
  EXPECT_LT(centreOf(picture, cv::Scalar::all(50)).first.y, 240);
}

TEST(ActivityPicture, ShowsThePacketInAllThreeProjections) {
  ActivityGrid activity(20, 36);
  activity.add({5, 15, 9}, 1.0);  // column, row, layer
  const cv::Mat picture = drawActivity(activity, ActivityTrail(), {600, 600});
  const double cell = kPanelHeight / 20.0;
  const double layer = kPanelHeight / 36.0;
  const cv::Point plane = brightest(picture, {0, 0, kPanelHeight, kPanelHeight});
  EXPECT_NEAR(plane.x, 5.5 * cell, cell);
  EXPECT_NEAR(plane.y, kPanelHeight - 15.5 * cell, cell);
  const cv::Point over_heading = brightest(picture, {kPanelHeight + 4, 0, kPanelHeight, kPanelHeight});
  EXPECT_NEAR(over_heading.x, 9.5 * layer, layer);
  EXPECT_NEAR(over_heading.y, kPanelHeight - 15.5 * cell, cell);
  const cv::Point over_x = brightest(picture, {0, kPanelHeight + 4, kPanelHeight, kPanelHeight});
  EXPECT_NEAR(over_x.x, 5.5 * cell, cell);
  EXPECT_NEAR(over_x.y, kPanelHeight - 9.5 * layer, layer);
}

TEST(ActivityPicture, DoesNotJoinTheTrailAcrossTheTorus) {
  const ActivityGrid activity(20, 36);
  const auto pixelsOfTrail = [&activity](const std::vector<double>& columns) {
    ActivityTrail trail;
    ActivityTrail end;
    for (const double x : columns) trail.add({x, 10.0, 0.0});
    end.add({columns.back(), 10.0, 0.0});
    const cv::Rect plane(0, 0, kPanelHeight, kPanelHeight);
    cv::Mat difference;
    cv::absdiff(drawActivity(activity, trail, {600, 600})(plane),
                drawActivity(activity, end, {600, 600})(plane), difference);
    return cv::countNonZero(difference.reshape(1));
  };
  EXPECT_GT(pixelsOfTrail({1.0, 10.0, 19.0}), 200);
  EXPECT_EQ(pixelsOfTrail({1.0, 19.0}), 0);
}

TEST(ActivityTrail, ForgetsTheOldest) {
  ActivityTrail trail;
  for (int i = 0; i < 1000; ++i) trail.add({static_cast<double>(i), 0.0, 0.0});
  EXPECT_EQ(trail.estimates().size(), ActivityTrail::kTrailLength);
  EXPECT_EQ(trail.estimates().back().x, 999.0);
}

TEST(MapPicture, HasNorthAtTheTopAndTellsRecallsApart) {
  ExperienceGraph graph;
  graph.addExperience({0.0, 0.0});
  graph.addExperience({0.0, 10.0});
  graph.addExperience({10.0, 10.0});
  Link link;
  link.from = 0;
  link.to = 1;
  graph.addLink(link);
  constexpr int kBlue = 0;
  constexpr int kGreen = 1;
  constexpr int kRed = 2;
  EXPECT_EQ(centreWhere(drawMap(graph, {}, {400, 400}), kRed, kBlue).second, 0);
  link.from = 1;
  link.to = 2;
  link.recall = true;
  graph.addLink(link);
  const cv::Mat picture = drawMap(graph, {10.0, 0.0}, {400, 400});
  const auto recall = centreWhere(picture, kRed, kBlue);
  EXPECT_GT(recall.second, 100);
  EXPECT_LT(recall.first.y, 50);
  const auto driven = centreWhere(picture, kBlue, kRed);
  EXPECT_LT(driven.first.x, 50);
  const auto robot = centreWhere(picture, kGreen, kBlue);
  EXPECT_GT(robot.first.x, 350);
  EXPECT_GT(robot.first.y, 350);
}

TEST(MapPicture, OfAnEmptyMapIsAPicture) {
  EXPECT_EQ(drawMap(ExperienceGraph(), {}, {400, 300}).size(), cv::Size(400, 300));
}

TEST(Composite, PutsThePartsInTheirPlaces) {
  const cv::Mat red(localViewPictureSize(), CV_8UC3, cv::Scalar(0, 0, 255));
  const cv::Mat green(100, 100, CV_8UC3, cv::Scalar(0, 255, 0));
  const cv::Mat picture = composite(red, green, cv::Mat());
  ASSERT_EQ(picture.size(), cv::Size(kCompositeWidth, kCompositeHeight));
  EXPECT_EQ(centreOf(picture, {0, 0, 255}).second, localViewPictureSize().area());
  const auto middle = centreOf(picture, {0, 255, 0}).first;
  EXPECT_NEAR(middle.x, kCompositeWidth / 4.0, 2.0);
  EXPECT_GT(middle.y, localViewPictureSize().height);
}

}  // namespace
}  // namespace ratslam
