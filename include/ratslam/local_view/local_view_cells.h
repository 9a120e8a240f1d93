/// Local view cells: each stands for a learned view, and each image makes exactly one of them active
/// (docs/model.md section 1; V^i of equation (4) of Malichev & Yakhno 2024).
///
/// For every image: make its template (view_template.h), search the learned templates for the one most like
/// it (template_matcher.h), then recall - the error is at most vt_match_threshold - or learn the template as
/// a new one.
///
/// A recall may be put to a RecallVerifier that looks at the image's geometry. What it does not confirm is
/// not recalled: a new template is learned instead. What it confirms takes its relative heading from the
/// geometry. It is not asked where the recalled template is the one active at the previous event or one of
/// the 10 most recently learned: the robot is still at that place, and a chance likeness of distant places is
/// not in question.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

#include "ratslam/common/stamp.h"
#include "ratslam/events.h"
#include "ratslam/local_view/block_sad/template_matcher.h"
#include "ratslam/local_view/block_sad/view_template.h"
#include "ratslam/local_view/local_view_params.h"

namespace ratslam {

class State;

/// Confirms or refuses recalls by image geometry.
struct RecallVerifier {
  RecallVerifier() = default;
  RecallVerifier(const RecallVerifier&) = delete;
  RecallVerifier& operator=(const RecallVerifier&) = delete;
  virtual ~RecallVerifier();

  /// Where `image` was taken relative to the place of view `view_id`; none where that place is not seen in
  /// it.
  virtual std::optional<RecallGeometry> verify(Stamp stamp, const cv::Mat& image, std::uint32_t view_id) = 0;

  /// Told of every learned view together with its image.
  virtual void learned(Stamp stamp, const cv::Mat& image, std::uint32_t view_id) = 0;
};

class LocalViewCells {
 public:
  /// @throws std::invalid_argument as LocalViewParams::validate does.
  explicit LocalViewCells(const LocalViewParams& params);

  /// The view cell that an image makes active. Types of image: see pixelFormat (grey.h).
  /// @param verifier asked about recalls and told of learned views; null: every recall stands.
  /// @throws std::invalid_argument for an unusable image, a crop or template that does not fit it, and an
  /// image of another size than the one before; the cells are then as before the call.
  ViewEvent observe(Stamp stamp, const cv::Mat& image, RecallVerifier* verifier = nullptr);

  /// The next image may have another size than those before; templates stay, as they have a size of their own.
  void acceptAnotherSize() { image_size_ = cv::Size(); }

  /// Number of view cells, equal to the number of learned templates.
  std::size_t size() const { return matcher_.size(); }

  const LocalViewParams& params() const { return params_; }

  /// Template `id` for display: 8-bit mono, one pixel a value. @throws std::out_of_range.
  cv::Mat templateImage(std::uint32_t id) const;

  /// The same of the present view, learned or not; empty before the first event.
  const cv::Mat& viewImage() const { return view_image_; }

  /// Memory held for the learned templates.
  std::size_t memoryBytes() const { return matcher_.memoryBytes(); }

  /// What the verifier measured for the present event; none where it was not asked or did not confirm.
  const std::optional<RecallGeometry>& recallGeometry() const { return geometry_; }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

 private:
  bool isOldView(std::uint32_t id) const;
  double shiftAngle(int shift) const;

  LocalViewParams params_;
  TemplateMatcher matcher_;
  cv::Size image_size_;                  // of the images, empty before the first
  std::optional<std::uint32_t> active_;  // view cell of the present event
  std::optional<RecallGeometry> geometry_;
  cv::Mat view_image_;
};

}  // namespace ratslam
