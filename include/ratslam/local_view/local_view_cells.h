/// Local view cells: each stands for a learned view, and each image makes exactly one of them active
/// (docs/model.md section 1; V^i of equation (4) of Malichev & Yakhno 2024).
///
/// For every image: describe it (descriptor.h), compare it with the learned views (matcher.h), then recall
/// one of them or learn the view as a new one. `vt_recall` says how: `nearest` recalls the learned view most
/// like this one where it is like enough; `belief` recalls the place that the views and the odometry before
/// make certain (recall/place_belief.h), or stays at the last place while the view is still the same.
/// An image in which there is nothing to see makes no cell active: it is neither learned nor recalled.
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
#include "ratslam/local_view/descriptor_registry.h"
#include "ratslam/local_view/local_view_params.h"
#include "ratslam/local_view/recall/place_belief.h"

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
  /// @throws std::invalid_argument as LocalViewParams::validate and DescriptorRegistry::make do.
  explicit LocalViewCells(const LocalViewParams& params,
                          const DescriptorRegistry& registry = DescriptorRegistry::builtIn());

  /// What an image looks like; each image of the stream once, in order. Types of image: see pixelFormat
  /// (grey.h). @throws std::invalid_argument for an unusable image, a crop or template that does not fit it,
  /// and an image of another size than the first had; the cells are then as before the call.
  View describe(const cv::Mat& image);

  /// The view cell that a view makes active; kNoView where there is nothing to see.
  /// @param image of the view, for the verifier alone.
  /// @param motion since the view before; only belief asks for it.
  /// @param verifier asked about recalls and told of learned views; null: every recall stands.
  ViewEvent observe(Stamp stamp, const View& view, const cv::Mat& image, const ViewMotion& motion,
                    RecallVerifier* verifier = nullptr);

  /// Both, each image counting as one step on.
  ViewEvent observe(Stamp stamp, const cv::Mat& image, RecallVerifier* verifier = nullptr);

  /// How like a view each learned view is: the graded activity V_i that equation (3) asks for before one cell
  /// is chosen. Of a view of no image: nothing.
  ViewLikeness likeness(const View& view);

  /// The next image may have another size than those before; learned views stay, as they have a size of their
  /// own.
  void acceptAnotherSize() { image_size_ = cv::Size(); }

  /// Whether views that are not recalled are learned; else they make no view cell active (kNoView).
  void setLearning(bool learning) { learning_ = learning; }
  bool learning() const { return learning_; }

  /// Number of view cells, equal to the number of learned templates.
  std::size_t size() const { return pair_.matcher->size(); }

  const LocalViewParams& params() const { return params_; }

  /// Learned view `id` for display: 8-bit mono. @throws std::out_of_range.
  cv::Mat templateImage(std::uint32_t id) const;

  /// Learned view `id`, for another map to look at. @throws std::out_of_range.
  View learned(std::uint32_t id) const { return pair_.matcher->learned(id); }

  /// The same of the present view, learned or not; empty before the first event.
  const cv::Mat& viewImage() const { return view_image_; }

  /// Memory held for the learned templates.
  std::size_t memoryBytes() const { return pair_.matcher->memoryBytes() + belief_.memoryBytes(); }

  /// What `vt_recall: belief` believes; nothing under `nearest`.
  const PlaceBelief& belief() const { return belief_; }

  /// What the verifier measured for the present event, and how far ahead of its place the belief has the robot; none where
  /// neither says anything.
  const std::optional<RecallGeometry>& recallGeometry() const { return geometry_; }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

 private:
  /// A learned view that may be recalled.
  struct Candidate {
    std::uint32_t id = 0;
    double relative_rad = 0.0;
    double error = -1.0;
    bool recalled = false;
    double ahead = 0.0;
  };

  bool isOldView(std::uint32_t id) const;
  Candidate nearest(const View& view);
  Candidate mostBelieved(const View& view);
  double noveltyOf(const View& view);
  static double turnOf(const View& view, const PlaceClaim& claim, const ViewMatch& match);

  LocalViewParams params_;
  bool learning_ = true;
  ViewPair pair_;
  PlaceBelief belief_;
  View before_;                          // the last that showed something, as far as belief asks for it
  cv::Size image_size_;                  // of all images, empty before the first
  std::optional<std::uint32_t> active_;  // view cell of the present event
  std::optional<RecallGeometry> geometry_;
  cv::Mat view_image_;
  ViewLikeness likeness_;
};

}  // namespace ratslam
