/// The robot's position along a path past a learned place, from the similarity of the present view to three templates.
///
/// On a short path the similarity of a view to a template falls linearly with the distance between them, at the same
/// rate in both directions. So the similarities to three templates on the path determine the position of the peak. A
/// template so far away that the similarity would have faded by then, as beyond a stretch without templates, tells
/// nothing.
#pragma once

namespace ratslam {

struct LikenessAlong {
  double distance = 0.0;  ///< along the path, from the middle one of three places [m]
  double likeness = 0.0;
};

/// Position of the largest likeness on a path through three places. It is limited to half the distance to the next
/// place on either side.
/// @param at  likeness of the middle place
/// @param faded  likeness of places far away: the mean over all places
/// @return distance from the middle place [m]; 0 if the middle one has the least likeness, if one of the others is too
/// far away, or if the places are not in order along the path
double likestBetween(const LikenessAlong& before, double at, const LikenessAlong& after, double faded);

}  // namespace ratslam
