/// Pose of an image relative to the image of a recalled template: two- and three-view geometry of a calibrated camera
/// (Hartley and Zisserman, Multiple View Geometry, 2003, ch. 9-12).
///
/// Learning of a template:
/// 1. Extract ORB features of its image, and match them with those of a companion image a few frames earlier.
/// 2. Estimate the relative pose of the two by epipolar consensus and bundle adjustment, and the inverse depths of
///    the matched features in units of the distance between the two images. If the parallax is too small, try an
///    earlier companion. A template may be left without a companion.
///
/// Verification of a recall:
/// 1. Extract ORB features of the present image, and match them with the template's.
/// 2. Estimate a first pose by resection with the template's depths; without a companion by epipolar consensus.
/// 3. Adjust template, companion and present image together. The results are the heading, the direction of the offset,
///    and its length as a ratio to the distance companion -> template, with their covariance from the residuals.
///    Without a companion the length is unknown. If a pure rotation explains the matches, the direction is unknown,
///    too.
///
/// There are three answers: none (rejected: the image does not show that place), a geometry with inliers > 0
/// (confirmed), and one with inliers = 0 (unknown: `vt_verify` is none, the template was dropped, or it has too few
/// features for a confirmation).
///
/// Memory: a template takes at most 60 bytes per feature and less than a kilobyte in addition
/// (30 kB with 500 features). All templates take at most vt_verify_max_templates times that (150 MB with 5000). If
/// there are too many, the template whose neighbours were learned closest to each other in time is dropped, so that
/// the others cover the path evenly. The last 13 grey images are kept as well, with the features of those that needed
/// them.
///
/// Cost: frame() copies an image. A learned or verified image is extracted once, with three times as many features as
/// a template has, so that the template's own features are found again.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ratslam/events.h"
#include "ratslam/local_view/recall/recall_geometry_params.h"
#include "ratslam/vision/recall_bundle.h"
#include "ratslam/vision/recall_consensus.h"
#include "ratslam/vision/recall_features.h"

namespace ratslam {

class State;

class RecallGeometryEstimator {
 public:
  /// @throws std::invalid_argument for bad parameters or a bad camera
  RecallGeometryEstimator(const RecallGeometryParams& params, const CameraModel& camera);

  /// To be called with every image, in order: the last ones serve as companions of templates. Only copies the image.
  /// If the stamp is earlier than the last one, the earlier images are forgotten.
  /// @throws std::invalid_argument for an empty image, an unknown pixel format or a size unlike the camera's
  void frame(Stamp stamp, const cv::Mat& image);

  /// To be called with every learned template and its image. @throws std::invalid_argument as frame()
  void learned(Stamp stamp, const cv::Mat& image, std::uint32_t view_id);

  /// Pose of `image` relative to the image of template `view_id`: none, a measurement, or the unknown geometry with
  /// inliers = 0 (see above). `distance` is never set, because it needs odometry.
  /// @throws std::invalid_argument as frame()
  std::optional<RecallGeometry> verify(Stamp stamp, const cv::Mat& image, std::uint32_t view_id);

  /// @throws std::invalid_argument for an image whose size is not the camera's
  void requireSize(const cv::Mat& image) const;

  std::size_t templates() const { return templates_.size(); }
  /// Bytes that the stored templates take.
  std::size_t memoryBytes() const;

  const RecallGeometryParams& params() const { return params_; }

  /// Saves templates and the last images. Features of the images are extracted again when they are needed.
  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit
  void load(const State& state);

 private:
  struct Frame {
    Stamp stamp = 0;
    cv::Mat grey;
    std::optional<RecallFeatures> features;  // once needed

    void save(State& state) const;
    void load(const State& state);
  };
  /// The companion image of a template, with one entry per feature of the template.
  struct Companion {
    Stamp stamp = 0;
    RecallView view;                        // unit translation
    std::vector<Eigen::Vector2f> bearings;  // NaN if the companion does not show the feature
    std::vector<float> inverse_depths;      // likewise
    std::vector<float> sigmas;              // of the companion's bearings

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("rotation", view.R);
      fields("translation", view.t);
      fields("motion", view.motion);
      fields("bearings", bearings);
      fields("inverse_depths", inverse_depths);
      fields("sigmas", sigmas);
    }
  };
  struct Template {
    Stamp stamp = 0;
    RecallFeatures features;
    std::optional<Companion> companion;
  };
  /// A template as a row of a table in a State.
  struct TemplateRow;

  Frame& present(Stamp stamp, const cv::Mat& image);
  const RecallFeatures& featuresOf(Frame& frame) const;
  std::optional<Companion> companionOf(const RecallFeatures& features, Frame& frame) const;
  /// Adds the companion to a bundle of template and present image, whose points are those of the matches.
  static void addCompanion(RecallBundle& bundle, const Template& then,
                           const std::vector<RecallMatch>& matches);
  void dropOne();

  RecallGeometryParams params_;
  CameraModel camera_;
  bool active_;
  std::deque<Frame> ring_;
  /// States share the templates, so templates never change.
  std::map<std::uint32_t, std::shared_ptr<const Template>> templates_;
};

}  // namespace ratslam
