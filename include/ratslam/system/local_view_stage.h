/// The local view cells with their stamped streams: images and, with vt_recall belief, odometry, which moves the
/// belief.
///
/// An image is described when it comes. With belief its view cell is decided once the odometry has reached its stamp;
/// with vt_recall nearest at once. The result depends only on stamps and values.
///
/// Nothing is learned or recalled from a frozen or blank frame. Its event has no view: the pose cells process its
/// stamp, and only odometry moves them.
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

/// Result of a frame.
struct ViewObservation {
  ViewEvent view;
  /// One for each frame if recalls are verified or made by belief, else none. Inliers 0: geometry was not measured.
  std::optional<RecallGeometry> geometry;
};

/// Whether each view has a RecallGeometry, and its source.
GeometrySource geometrySource(const ViewRecallParams& recall, const RecallGeometryParams& geometry);

class LocalViewStage {
 public:
  /// @throws std::invalid_argument for bad parameters
  LocalViewStage(const LocalViewParams& params, const RecallGeometryParams& recall_params,
                 const OdometryStreamParams& stream = {});

  /// Whether setCamera must be called before the first frame.
  bool needsCamera() const { return recall_params_.verifies() && !recall_check_; }
  /// Sets the camera for the verification of recalls. Does nothing if recalls are not verified.
  /// @throws std::invalid_argument for a bad camera
  void setCamera(const CameraModel& camera);

  GeometrySource geometrySource() const {
    return ratslam::geometrySource(cells_.params().recall, recall_params_);
  }
  bool needsOdometry() const { return cells_.params().recall.believes(); }

  /// kTimeWentBack: the sample opens a new time, which begins once the images have gone back, too (event_gate.h).
  SampleVerdict addOdometry(const OdometrySample& sample);
  /// Samples that were held by their stamps and have been decided (event_gate.h).
  std::vector<DecidedSample> takeDecided();
  /// Announces an image of this stamp, which may decide on a held sample.
  void expect(Stamp stamp) { gate_.expect(stamp); }
  /// To be called after the last sample.
  void endOdometry();

  /// @throws std::invalid_argument as LocalViewCells::describe does; std::logic_error without its camera
  EventVerdict addFrame(const ImageFrame& frame);

  /// Observations of the images that pass, oldest first. All pass if no odometry is needed.
  std::vector<ViewObservation> drain(Passing which = Passing::kReached);

  /// Epoch of dead reckoning to which the next view belongs (recall/place_graph.h).
  std::uint32_t epoch() const { return epoch_ + static_cast<std::uint32_t>(gate_.beginnings()); }

  std::size_t waitingImages() const { return gate_.size(); }
  std::vector<Stamp> waitingStamps() const { return gate_.waitingStamps(); }
  /// Numbers of images that were dropped: ahead of time, and never reached by the odometry.
  std::uint64_t aheadImages() const { return gate_.aheadEvents(); }
  std::uint64_t unreachedImages() const { return gate_.unreachedEvents(); }
  /// Whether the images have gone back in time and the odometry has not yet.
  bool waitsForOdometryToGoBack() const { return gate_.waitsForOdometryToGoBack(); }
  const LocalViewCells& cells() const { return cells_; }
  LocalViewCells& cells() { return cells_; }

  /// Clears the streams, before another drive or another part of the same drive.
  void interrupt();
  /// Drops the images that wait, after load(): the process that saved the state went on and decided on them.
  void forgetWaiting() { gate_.forgetWaiting(); }

  /// Whether to learn views that are not recalled. If not, they make no view cell active.
  void setLearning(bool learning) { cells_.setLearning(learning); }

  /// Sets other parameters for all views later than `after`. Only those of changeableKeys may differ.
  /// @throws std::invalid_argument for bad ones
  void change(Stamp after, const LocalViewParams& params) {
    params.validate();
    changes_.add(after, params);
  }
  /// The stamp after which a change made now holds.
  Stamp latestProcessed() const { return changes_.latest(gate_.latestPassed()); }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

 private:
  /// A described image that waits for the odometry.
  struct WaitingView {
    Stamp stamp = 0;
    View view;
    cv::Mat image;  ///< for the verifier; empty without one

    template <class Fields>
    void stateFields(Fields&& fields);
  };

  /// Uncertainty of one sample of odometry.
  struct Certainty {
    Stamp stamp = 0;
    std::optional<double> forward_variance;  ///< [m^2]
    std::optional<double> yaw_variance;      ///< [rad^2]
    std::uint32_t epoch = 0;
    double unmeasured_s = 0.0;  ///< time since the sample before, if its motion is unmeasured; else 0 [s]

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("forward_variance", forward_variance);
      fields("yaw_variance", yaw_variance);
      fields("epoch", epoch);
      fields("unmeasured_s", unmeasured_s);
    }
  };

  void follow(const DecidedSample& decided);
  void follow(const OdometrySample& sample, bool back, bool broken);
  void settleAside();
  std::vector<DecidedSample> followDecided();
  void joinOldest();
  ViewMotion motionUntil(Stamp stamp);
  ViewObservation process(const WaitingView& waiting);

  RecallGeometryParams recall_params_;
  OdometryStreamParams stream_;
  LocalViewCells cells_;
  TimedChanges<LocalViewParams> changes_;
  std::unique_ptr<RecallCheck> recall_check_;  ///< only with vt_verify, once the camera is known
  EventGate<WaitingView> gate_;
  std::deque<OdometrySample> aside_;  ///< of a time that has not begun (EventGate::isPutAside)
  std::uint64_t beginnings_ = 0;      ///< times that the odometry's time had begun anew at the last view
  std::vector<DecidedSample> decided_;
  std::deque<Certainty> certainties_;  ///< of the samples that no view has used yet
  std::optional<Stamp> last_sample_;
  std::uint32_t source_epoch_ = 0;  ///< of the last sample
  /// Epoch of dead reckoning without the new beginnings of the odometry's time, which epoch() adds. It grows if the
  /// source's epoch changes, at the begin and the end of unmeasured motion, and with interrupt().
  std::uint32_t epoch_ = 0;
};

}  // namespace ratslam
