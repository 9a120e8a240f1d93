/// The whole system without ROS: Fig. 1 of the paper as code.
///
///     image -> visual odometry -----------------+------------------+
///       |                                       v                  v
///       +----> local view cells -> view -> pose cells -> action -> experience map
///
/// Each node runs one model and exchanges topics. The pipeline runs all models in one process. Both use the same
/// stages and give the same map to the last bit.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ratslam/camera/camera_params.h"
#include "ratslam/common/parameter_map.h"
#include "ratslam/odometry/odometry_doubts.h"
#include "ratslam/odometry/registry.h"
#include "ratslam/odometry/source.h"
#include "ratslam/system/image_stage.h"
#include "ratslam/system/local_view_stage.h"
#include "ratslam/system/map_stage.h"
#include "ratslam/system/pose_cell_stage.h"

namespace ratslam {

class State;

/// The parameters of all models.
struct PipelineParams {
  LocalViewParams local_view;
  PoseCellParams pose_cells;
  ExperienceMapParams experience_map;
  OdometryParams odometry;  ///< of all odometries
  CameraParams camera;
  RecallGeometryParams recall_geometry;
  ImageStageParams images;
  OdometryStreamParams odometry_stream;

  /// @throws std::invalid_argument for a bad value, naming key, value, requirement and origin
  static PipelineParams fromMap(const ParameterMap& map);
  /// Keys that a shared configuration file may contain: those of all models and of the nodes.
  static std::set<std::string> knownKeys();
  /// Calls visit(key, value, bounds, meaning) for every parameter of every model.
  template <class Visitor>
  void visitFields(Visitor&& visit) {
    local_view.visitFields(visit);
    pose_cells.visitFields(visit);
    experience_map.visitFields(visit);
    odometry.visitFields(visit);
    camera.visitFields(visit);
    recall_geometry.visitFields(visit);
    images.visitFields(visit);
    odometry_stream.visitFields(visit);
  }
};

/// Computing time of each model so far [s]. It never influences a result.
struct ModuleTimes {
  double odometry = 0.0;
  double local_view = 0.0;
  double pose_cells = 0.0;
  double experience_map = 0.0;
};

class Pipeline {
 public:
  /// Results of one image or one sample of odometry.
  struct Progress {
    std::vector<OdometrySample> odometry;     ///< computed from the image, or accepted from outside
    std::vector<ViewEvent> views;             ///< view events of this image or of earlier ones, oldest first
    std::vector<std::string> refusals;        ///< why odometry or local view cannot use the image
    std::vector<PoseCellDecision> decisions;  ///< oldest first
    std::vector<Stamp> mapped;  ///< stamps of the decisions that the map has processed, oldest first
    std::vector<std::string> map_refusals;  ///< why the map cannot process some of the decisions
  };

  /// @param odometry  computes odometry from images; null if odometry comes through `addOdometry`
  /// @param camera    needed if image geometry verifies recalls (vt_verify)
  /// @throws std::invalid_argument for bad parameters, or vt_verify without a camera
  Pipeline(const PipelineParams& params, std::unique_ptr<OdometrySource> odometry,
           const std::optional<CameraModel>& camera = std::nullopt);

  /// To be called before addImage, with the image's stamp. An odometry sample that is held because it jumps ahead
  /// (event_gate.h) is accepted if the image reaches its stamp. @return the results of that sample alone
  Progress expectImage(Stamp stamp);
  /// Processes an image. If one of the models cannot use it, only that model leaves it out, as its node would.
  Progress addImage(const ImageFrame& frame);
  /// Processes a sample of odometry. One that is impossible, repeats a stamp or is late is left out and counted.
  Progress addOdometry(const OdometrySample& sample);
  /// To be called when no odometry will follow. A last sample that is held because it jumps ahead is then accepted.
  Progress endOdometry();

  /// Solves the map to its optimum. The newest pose of the online trajectory does not change.
  void settle() { map_.map().settle(); }

  const LocalViewCells& localView() const { return local_view_.cells(); }
  /// The source of odometry; null if odometry comes from outside.
  const OdometrySource* odometry() const { return odometry_.get(); }
  const PoseCellStage& poseCells() const { return pose_cells_; }
  const ExperienceMap& map() const { return map_.map(); }
  const ModuleTimes& times() const { return times_; }
  /// Number of samples of odometry that were dropped, and the reason for the first one; the reason is empty if that
  /// sample was dropped before the loaded state was saved.
  std::size_t droppedOdometry() const { return dropped_odometry_ + pose_cells_.odometryLeftBehind(); }
  std::string firstDrop() const;
  /// Number of views with a stamp a little before that of the view before, or ahead of time.
  std::size_t lateViews() const { return late_views_ + local_view_.aheadImages() + pose_cells_.aheadViews(); }
  /// The images that wait for odometry: stamps of those without a view event, and of view events.
  std::vector<Stamp> waitingImages() const { return local_view_.waitingStamps(); }
  std::vector<Stamp> waitingViews() const { return pose_cells_.waitingStamps(); }
  /// Number of images that were dropped, because both streams went back in time before the odometry reached them.
  std::size_t unreachedViews() const {
    return unreached_views_ + local_view_.unreachedImages() + pose_cells_.unreachedViews();
  }
  /// Number of samples with an unusable covariance, and what is wrong with the first of them.
  std::size_t absurdCovariances() const { return absurd_covariances_; }
  const std::string& firstAbsurdity() const { return first_absurdity_; }
  /// What makes odometry from outside doubtful (odometry_doubts.h).
  const std::vector<std::string>& odometryDoubts() const { return odometry_doubts_; }
  /// Number of unmeasured stretches of odometry.
  std::size_t unmeasuredStretches() const {
    return unmeasured_stretches_ + pose_cells_.odometry().unmeasured();
  }
  /// Number of decisions that the map cannot process, and the reason for the first of them.
  std::size_t refusedDecisions() const { return refused_decisions_; }
  const std::string& firstRefusal() const { return first_refusal_; }

  /// To be called before another drive: its path begins unconnected in the same map.
  void interrupt();

  /// Whether to learn and localise, or to localise only.
  void setLearning(bool learning);

  /// Sets other thresholds and gains for events later than `after` (parameter_changes.h).
  void change(Stamp after, const LocalViewParams& params) { local_view_.change(after, params); }
  void change(Stamp after, const PoseCellParams& params) { pose_cells_.change(after, params); }
  void change(Stamp after, const ExperienceMapParams& params) { map_.change(after, params); }

  /// Saves everything that the results of later calls depend on.
  void save(State& state) const;
  /// @param go_on  whether the recording continues at the saved point. If not, interrupt() is called and the
  /// odometry starts anew.
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state, bool go_on);

 private:
  void track(const ImageFrame& frame, Progress& progress);
  void observe(const ImageFrame& frame, Progress& progress);
  std::vector<OdometrySample> feedOdometry(const OdometrySample& sample);
  /// Those of the held samples that were accepted.
  std::vector<OdometrySample> takeDecided();
  bool isTaken(const OdometrySample& sample, SampleVerdict verdict);
  void drain(Progress& progress);
  void loadCounts(const State& counts);

  std::unique_ptr<OdometrySource> odometry_;
  LocalViewStage local_view_;
  PoseCellStage pose_cells_;
  MapStage map_;
  ModuleTimes times_;
  std::size_t dropped_odometry_ = 0;
  std::string first_drop_;
  std::size_t late_views_ = 0;
  std::size_t unreached_views_ = 0;
  std::size_t absurd_covariances_ = 0;
  std::string first_absurdity_;
  std::size_t unmeasured_stretches_ = 0;  ///< before the last interrupt()
  std::size_t refused_decisions_ = 0;
  std::string first_refusal_;
  OdometryDoubts doubts_;
  std::vector<std::string> odometry_doubts_;
};

}  // namespace ratslam
