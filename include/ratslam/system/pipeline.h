/// The whole system without ROS: Fig. 1 of the paper as code.
///
///     image -> visual odometry -----------------+------------------+
///       |                                       v                  v
///       +----> local view cells -> view -> pose cells -> action -> experience map
///
/// The nodes run one model each over topics; this runs them in one process. Both use the same stages and give
/// the same map to the last bit.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ratslam/camera/camera_params.h"
#include "ratslam/common/parameter_map.h"
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
  OdometryParams odometry;  ///< of all there are
  CameraParams camera;
  RecallGeometryParams recall_geometry;
  ImageStageParams images;
  OdometryStreamParams odometry_stream;

  /// @throws std::invalid_argument for a bad value, naming key, value, what would be right and the origin
  static PipelineParams fromMap(const ParameterMap& map);
  /// Keys of all models and of the nodes around them: what a shared configuration file may contain.
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

/// Seconds of computing time that each model has taken so far. Not a result: it never influences one.
struct ModuleTimes {
  double odometry = 0.0;
  double local_view = 0.0;
  double pose_cells = 0.0;
  double experience_map = 0.0;
};

class Pipeline {
 public:
  /// What one image, or one sample of odometry, has set in motion.
  struct Progress {
    std::vector<OdometrySample> odometry;     ///< made from the image, or accepted from outside
    std::vector<ViewEvent> views;             ///< view events that have become possible
    std::vector<std::string> refusals;        ///< why odometry or local view cannot use the image
    std::vector<PoseCellDecision> decisions;  ///< that have become possible, oldest first
    std::vector<Stamp> mapped;                ///< stamps up to which the map has got, oldest first
  };

  /// @param odometry  makes odometry of images; none where it comes from outside through `addOdometry`
  /// @param camera    needed where image geometry verifies recalls (vt_verify)
  /// @throws std::invalid_argument for bad parameters, or vt_verify without a camera
  Pipeline(const PipelineParams& params, std::unique_ptr<OdometrySource> odometry,
           const std::optional<CameraModel>& camera = std::nullopt);

  /// An image that does not suit one of the models is refused by that one alone, as by its node.
  Progress addImage(const ImageFrame& frame);
  /// A sample that is not finite, repeats a stamp or comes late is left out and counted.
  Progress addOdometry(const OdometrySample& sample);

  /// Brings the map to the optimum of all that is known. The newest online pose stays what it was.
  void settle() { map_.map().settle(); }

  const LocalViewCells& localView() const { return local_view_.cells(); }
  /// The source of odometry; none where it comes from outside.
  const OdometrySource* odometry() const { return odometry_.get(); }
  const PoseCellStage& poseCells() const { return pose_cells_; }
  const ExperienceMap& map() const { return map_.map(); }
  const ModuleTimes& times() const { return times_; }
  std::size_t droppedOdometry() const { return dropped_odometry_; }
  /// Views whose stamp lay a little before the view before.
  std::size_t lateViews() const { return late_views_; }
  /// Samples whose covariance cannot be used, and what is wrong with the first of them.
  std::size_t absurdCovariances() const { return absurd_covariances_; }
  const std::string& firstAbsurdity() const { return first_absurdity_; }
  /// Stretches of odometry that nobody measured.
  std::size_t unmeasuredStretches() const { return pose_cells_.odometry().unmeasured(); }

  /// What comes next is another drive, or another part of this one: a new stretch begins in the same map.
  void interrupt();

  /// Whether anything is learned; else the robot only finds its place in what is known.
  void setLearning(bool learning);

  /// Other thresholds and gains for what is later than `after` (parameter_changes.h).
  void change(Stamp after, const LocalViewParams& params) { local_view_.change(after, params); }
  void change(Stamp after, const PoseCellParams& params) { pose_cells_.change(after, params); }
  void change(Stamp after, const ExperienceMapParams& params) { map_.change(after, params); }

  /// Everything that the results of later calls depend on.
  void save(State& state) const;
  /// @param go_on  the recording goes on where the saved one ended; else interrupt() is called, and the
  /// odometry starts anew
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state, bool go_on);

 private:
  void track(const ImageFrame& frame, Progress& progress);
  void observe(const ImageFrame& frame, Progress& progress);
  bool feedOdometry(const OdometrySample& sample);
  void drain(Progress& progress);

  std::unique_ptr<OdometrySource> odometry_;
  LocalViewStage local_view_;
  PoseCellStage pose_cells_;
  MapStage map_;
  ModuleTimes times_;
  std::size_t dropped_odometry_ = 0;
  std::size_t late_views_ = 0;
  std::size_t absurd_covariances_ = 0;
  std::string first_absurdity_;
};

}  // namespace ratslam
