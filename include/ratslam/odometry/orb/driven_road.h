/// The camera's height above patches of road, at the moment when it passes over them.
///
/// A patch of road is seen some camera heights ahead (ground_plane.h). If the road's slope changes in between, the
/// patch's plane, continued to the camera, passes too high or too low: 1 degree over 4 heights is an error of 7 %. So
/// the height is measured when the camera is above the patch, or, if it drives backwards, where it was above the patch
/// before. The path from the sighting to there comes from the odometry, whose error over that distance is negligible.
///
/// All positions are kept in the axes of the newest keyframe's camera, in the odometry's present unit.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "ratslam/odometry/orb/ground_plane.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam {

struct DrivenHeight {
  double height = 0.0;     ///< of the camera above a patch that it passed over [odometry unit]
  double sigma_log = 0.0;  ///< standard deviation of its log
};

class DrivenRoad {
 public:
  /// Moves on to the next keyframe. @param T_now_before from the axes of the keyframe before to those of the new one
  /// @param camera_height approximate; it only bounds what is kept, and a step of more than twice this height drops all
  /// patches
  /// @return the heights above the patches that the camera passed over in between, oldest patch first
  std::vector<DrivenHeight> moveOn(const RigidTransform& T_now_before, double camera_height);
  /// Adds a patch seen from the newest keyframe. Of patches close to each other only the first is kept.
  /// @return the height if the camera has passed over the patch before
  std::optional<DrivenHeight> add(const RoadMeasurement& road);
  /// Converts everything to a new unit of length.
  void rescale(double factor);
  void clear() { *this = DrivenRoad(); }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("patches", patches_);
    fields("path", path_);
  }

 private:
  struct Patch {
    RoadPlane plane;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double sigma_log = 0.0;
    double way = 0.0;  // driven since the patch was seen

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("normal", plane.normal);
      fields("height", plane.height);
      fields("centre", centre);
      fields("sigma_log", sigma_log);
      fields("way", way);
    }
  };
  static std::optional<DrivenHeight> heightAbove(const Patch& patch, const Eigen::Vector3d& from,
                                                 const Eigen::Vector3d& to);

  std::deque<Patch> patches_;  // not passed over yet
  // Places of the camera up to the newest keyframe; empty before the first moveOn.
  std::deque<Eigen::Vector3d> path_;
};

}  // namespace ratslam
