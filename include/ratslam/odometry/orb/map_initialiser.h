/// Starts a map: waits until the camera has moved enough from a reference frame, then makes the first two
/// keyframes and triangulates their landmarks.
///
/// The reference is kept as long as it has enough matches, so that a slow camera gathers parallax. Along a straight street
/// near points may be lost before far ones have moved enough. Once a reference was lost in this way, many points make up for
/// little parallax: the error of a motion falls with the root of their number.
#pragma once

#include <memory>
#include <optional>

#include "ratslam/odometry/orb/motion_history.h"
#include "ratslam/vision/local_map.h"
#include "ratslam/vision/two_view.h"

namespace ratslam {

struct InitialMap {
  std::shared_ptr<Frame> first;   ///< pose identity
  std::shared_ptr<Frame> second;  ///< pose relative to it, with observations
  LocalMap map;                   ///< median depth of the landmarks in `second` is 1
};

class MapInitialiser {
 public:
  /// Where an initialiser is on its way to a map.
  struct Progress {
    bool short_of_parallax = false;  ///< a motion since the reference was certain but for its parallax
    bool lost_reference = false;     ///< an earlier reference was so until its matches were lost

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("short_of_parallax", short_of_parallax);
      fields("lost_reference", lost_reference);
    }
  };

  MapInitialiser(const CameraModel& camera, const TwoViewParams& params, int map_keyframes)
      : camera_(camera), params_(params), map_keyframes_(map_keyframes) {}

  /// Reference frame of the next map; null before the first frame.
  const std::shared_ptr<Frame>& reference() const { return reference_; }
  /// Adds the next frame. @param turn from the reference to this frame, if it has been measured otherwise. It
  /// predicts the positions of matches, and a map with another turn is rejected: two views of points at one depth
  /// can confuse a turn with a sideways motion. @return a map as soon as the frames allow one.
  std::optional<InitialMap> add(const std::shared_ptr<Frame>& frame,
                                const std::optional<UncertainTurn>& turn = std::nullopt);
  void reset() { resume(nullptr, {}); }
  const Progress& progress() const { return progress_; }
  /// Goes on from a saved reference and progress.
  void resume(std::shared_ptr<Frame> reference, const Progress& progress);
  /// Sets another calibration for later frames. To be called only after reset().
  void setCamera(const CameraModel& camera) { camera_ = camera; }

 private:
  bool hasParallax(const TwoViewMotion& motion) const;
  std::optional<InitialMap> makeMap(const std::shared_ptr<Frame>& frame,
                                    const std::vector<std::pair<int, int>>& pairs,
                                    const std::vector<Eigen::Vector2d>& second,
                                    const TwoViewMotion& motion) const;

  CameraModel camera_;
  TwoViewParams params_;
  int map_keyframes_;
  std::shared_ptr<Frame> reference_;
  Progress progress_;
};

}  // namespace ratslam
