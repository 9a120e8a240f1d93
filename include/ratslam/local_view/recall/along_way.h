/// Where on the way past a place the robot is.
///
/// A view changes evenly along a short way: how like it is to one learned d metres away falls by the same for each
/// metre, whichever way. From how like it is to three views of one way follows where on it that peak lies.
#pragma once

namespace ratslam {

struct LikenessAlong {
  double distance = 0.0;  ///< on the way, from the middle one of three places [m]
  double likeness = 0.0;
};

/// Where a view is most like what was learned on the way between three places, at most half the way to the next on
/// either side; 0 where the middle one is the least like it, or the places do not follow each other.
/// @param at  likeness of the middle one   @return distance from the middle place [m]
double likestBetween(const LikenessAlong& before, double at, const LikenessAlong& after);

}  // namespace ratslam
