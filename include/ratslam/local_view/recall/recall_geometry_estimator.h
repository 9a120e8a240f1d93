/// Where an image was taken relative to a recalled template: two- and three-view geometry of a calibrated
/// camera (Hartley and Zisserman, Multiple View Geometry, 2003, ch. 9-12).
///
/// A template is learned:
/// 1. ORB features of its image, matched to those of a companion image a few frames earlier.
/// 2. Relative pose of the two by epipolar consensus and bundle adjustment, and inverse depths of the matched
///    features in units of the way between the two. Too little parallax: an earlier companion, or none.
///
/// A recall is verified:
/// 1. ORB features of the present image, matched to the template's.
/// 2. A first pose by resection against the template's depths; without a companion by epipolar consensus.
/// 3. Bundle adjustment of template, companion and present image together: heading, offset, and the offset's
///    length as a ratio to the way companion -> template, with the covariance that the residuals have.
///    Without a companion only the direction is known, and not even that where a mere rotation explains the
///    matches.
///
/// Three answers: nothing (rejected: the image does not show that place), a geometry with inliers > 0
/// (confirmed) and one with inliers = 0 (unknown: `vt_verify` is none, the template was dropped, or it has
/// too few features for any image to be confirmed; the recall is neither supported nor contradicted).
///
/// Memory: a template takes at most bytesPerTemplate(), 60 bytes a feature and less than a kilobyte beside
/// (30 kB with 500 features), and all of them at most vt_verify_max_templates times that (150 MB with 5000).
/// When full, the template whose neighbours were learned closest to each other in time is dropped: what
/// remains covers the path evenly. Beside them the last 13 grey images are kept, with the features of those
/// that needed them.
///
/// Cost: frame() copies an image. A learned or verified image is extracted once, with three times a
/// template's features so that the template's own are found again.
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

  /// Told of every image, in order; the last ones serve as companions of templates. Keeps a copy, computes
  /// nothing. A stamp before the last one forgets the images before it.
  /// @throws std::invalid_argument for an empty image, an unknown pixel format or a size unlike the camera's
  void frame(Stamp stamp, const cv::Mat& image);

  /// Told of every learned template and its image. @throws std::invalid_argument as frame()
  void learned(Stamp stamp, const cv::Mat& image, std::uint32_t view_id);

  /// Where `image` was taken relative to the image of template `view_id`: nothing, a measurement, or the
  /// unknown geometry with inliers = 0 (see above). `distance` is never set: only odometry knows it.
  /// @throws std::invalid_argument as frame()
  std::optional<RecallGeometry> verify(Stamp stamp, const cv::Mat& image, std::uint32_t view_id);

  /// @throws std::invalid_argument for an image whose size is not the camera's
  void requireSize(const cv::Mat& image) const;

  std::size_t templates() const { return templates_.size(); }
  /// Bytes that the stored templates take.
  std::size_t memoryBytes() const;
  /// Most bytes that one template takes.
  static std::size_t bytesPerTemplate(int features);

  const RecallGeometryParams& params() const { return params_; }

  /// Templates and the last images; features of images are found again when they are needed.
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
  /// What the companion image adds to a feature of a template.
  struct Companion {
    Stamp stamp = 0;
    RecallView view;                        // unit translation
    std::vector<Eigen::Vector2f> bearings;  // one a feature, NaN where the companion does not show it
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
  /// A template as a row of a table.
  struct TemplateRow;

  Frame& present(Stamp stamp, const cv::Mat& image);
  const RecallFeatures& featuresOf(Frame& frame) const;
  std::optional<Companion> companionOf(const RecallFeatures& features, Frame& frame) const;
  /// Joins the companion to a bundle of template and present image, whose points are those of the matches.
  static void addCompanion(RecallBundle& bundle, const Template& then,
                           const std::vector<RecallMatch>& matches);
  void dropOne();

  RecallGeometryParams params_;
  CameraModel camera_;
  bool active_;
  std::deque<Frame> ring_;
  std::map<std::uint32_t, std::shared_ptr<const Template>>
      templates_;  ///< shared with States: nobody changes one
};

}  // namespace ratslam
