#include "ratslam/system/odometry_span.h"

#include <gtest/gtest.h>

namespace ratslam {
namespace {

OdometrySpan span(double view_from, double view_to, double from, double to) {
  OdometrySpan span;
  for (double t = view_from; t < view_to - 1e-9; t += 0.1) span.addView(stampFromSeconds(t));
  for (double t = from; t < to + 1e-9; t += 0.05) span.addOdometry(stampFromSeconds(t));
  return span;
}

TEST(OdometrySpanTest, NothingIsSaidWhereAllImagesLieInside) {
  EXPECT_EQ(span(10.0, 20.0, 9.9, 20.0).complaint(), std::nullopt);
}

TEST(OdometrySpanTest, AClockBehindOrAheadIsNamedWithItsOffset) {
  EXPECT_EQ(*span(3700.0, 3790.0, 99.8, 189.8).complaint(),
            "900 of 900 images lie outside the odometry's time: it is 3600.2 s behind");
  EXPECT_EQ(*span(0.0, 90.0, 80.0, 170.0).complaint(),
            "800 of 900 images lie outside the odometry's time: it is 80.0 s ahead");
}

TEST(OdometrySpanTest, OdometryThatIsShorterIsSaidSo) {
  EXPECT_EQ(*span(10.0, 20.0, 9.9, 14.95).complaint(),
            "50 of 100 images lie outside the odometry's time: it ends 5.0 s before them");
  EXPECT_EQ(
      *span(10.0, 20.0, 12.0, 15.05).complaint(),
      "69 of 100 images lie outside the odometry's time: it begins 2.0 s after them and ends 4.9 s before "
      "them");
}

TEST(OdometrySpanTest, ImagesInsideThatNeverReachedTheMapAreCounted) {
  OdometrySpan half = span(10.0, 20.0, 9.9, 14.95);
  half.end({stampFromSeconds(14.0), stampFromSeconds(21.0)}, {stampFromSeconds(12.0), stampFromSeconds(19.0)},
           3);
  EXPECT_EQ(half.viewsOutside(), 56U);
  OdometrySpan whole = span(10.0, 20.0, 9.9, 20.0);
  whole.end({}, {stampFromSeconds(12.0)}, 0);
  EXPECT_EQ(whole.viewsOutside(), 1U);
  EXPECT_EQ(whole.complaint()->find("1 of 100 images were never mapped: their time went back"), 0U);
}

TEST(OdometrySpanTest, NoOdometryAtAll) {
  OdometrySpan span;
  span.addView(5);
  EXPECT_EQ(*span.complaint(), "1 of 1 images lie outside the odometry's time: there is no odometry at all");
}

}  // namespace
}  // namespace ratslam
