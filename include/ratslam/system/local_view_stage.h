/// The local view cells fed by their stamped streams: images and, where recalls are a matter of belief
/// (vt_recall), the odometry that moves the belief.
///
/// An image is described when it comes. The view cell that it makes active is decided once the odometry has
/// reached its stamp; where only the nearest view counts, at once. The result depends on stamps and values
/// alone.
///
/// A frame that shows nothing (frozen, without texture) learns and recalls nothing: its event has no view, so
/// that the pose cells keep up with its stamp and the odometry alone moves them.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/camera/image_frame.h"
#include "ratslam/local_view/local_view_cells.h"
#include "ratslam/system/event_gate.h"
#include "ratslam/system/parameter_changes.h"
#include "ratslam/system/recall_check.h"

namespace ratslam {

class State;

/// What a frame gave.
struct ViewObservation {
  ViewEvent view;
  /// Where recalls are verified or belief recalls, one for each frame; inliers 0 where nothing was measured.
  std::optional<RecallGeometry> geometry;
};

/// Whether each view comes with a RecallGeometry, and what measured it.
GeometrySource geometrySource(const ViewRecallParams& recall, const RecallGeometryParams& geometry);

class LocalViewStage {
 public:
  /// @throws std::invalid_argument for bad parameters
  LocalViewStage(const LocalViewParams& params, const RecallGeometryParams& recall_params,
                 const OdometryStreamParams& stream = {});

  /// Whether it cannot observe before it has a camera.
  bool needsCamera() const { return recall_params_.verifies() && !recall_check_; }
  /// To be called once, before the first frame, where recalls are verified; else it does nothing.
  /// @throws std::invalid_argument for a bad camera
  void setCamera(const CameraModel& camera);

  GeometrySource geometrySource() const {
    return ratslam::geometrySource(cells_.params().recall, recall_params_);
  }
  bool needsOdometry() const { return cells_.params().recall.believes(); }

  /// kTimeWentBack has already reset the stream; the sample that told so sets the clock anew.
  SampleVerdict addOdometry(const OdometrySample& sample);

  /// @throws std::invalid_argument as LocalViewCells::describe does; std::logic_error without its camera
  EventVerdict addFrame(const ImageFrame& frame);

  /// Observations of the images that pass, oldest first; where no odometry is needed all pass.
  std::vector<ViewObservation> drain(Passing which = Passing::kReached);

  std::size_t waitingImages() const { return gate_.size(); }
  /// Whether the images have gone back in time and the odometry has not, so far.
  bool waitsForOdometryToGoBack() const { return gate_.waitsForOdometryToGoBack(); }
  const LocalViewCells& cells() const { return cells_; }
  LocalViewCells& cells() { return cells_; }

  /// Forgets what the streams have brought: what comes next is another drive, or another part of this one.
  void interrupt();

  /// Whether views that are not recalled are learned; else they make no view cell active.
  void setLearning(bool learning) { cells_.setLearning(learning); }

  /// Other parameters for all views later than `after`: those of changeableKeys may differ.
  /// @throws std::invalid_argument for bad ones
  void change(Stamp after, const LocalViewParams& params) {
    params.validate();
    changes_.add(after, params);
  }
  /// The stamp after which a change that is made now would hold.
  Stamp latestProcessed() const { return gate_.latestPassed(); }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

 private:
  /// A described image that waits for the odometry.
  struct WaitingView {
    Stamp stamp = 0;
    View view;
    cv::Mat image;  ///< for the verifier; else empty

    template <class Fields>
    void stateFields(Fields&& fields);
  };

  /// What one sample of odometry says of its own certainty.
  struct Certainty {
    Stamp stamp = 0;
    std::optional<double> forward_variance;  ///< [m^2]
    std::optional<double> yaw_variance;      ///< [rad^2]
    std::uint32_t epoch = 0;
    double unmeasured_s = 0.0;  ///< time since the sample before it, where nobody measured the way [s]

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("forward_variance", forward_variance);
      fields("yaw_variance", yaw_variance);
      fields("epoch", epoch);
      fields("unmeasured_s", unmeasured_s);
    }
  };

  void joinOldest();
  ViewMotion motionUntil(Stamp stamp);
  ViewObservation process(const WaitingView& waiting);

  RecallGeometryParams recall_params_;
  OdometryStreamParams stream_;
  LocalViewCells cells_;
  TimedChanges<LocalViewParams> changes_;
  std::unique_ptr<RecallCheck> recall_check_;  ///< where vt_verify asks for it, once the camera is known
  EventGate<WaitingView> gate_;
  std::deque<Certainty> certainties_;  ///< of samples that no view has used yet
  std::optional<Stamp> last_sample_;
  std::uint32_t source_epoch_ = 0;  ///< of the last sample
  std::uint32_t epoch_ = 0;         ///< changes with the source's and when time goes back
};

}  // namespace ratslam
