/// Local view cells: each stands for a learned view, and each image makes exactly one of them active
/// (docs/model.md section 1; V^i of equation (4) of Malichev & Yakhno 2024).
///
/// Steps for every image: describe it (descriptor.h), compare it with the learned views (matcher.h), then recall one
/// of them or learn the view as a new one. `vt_recall` selects the method. `nearest` recalls the most similar learned
/// view if it is similar enough. `belief` recalls the place that views and odometry make certain
/// (recall/place_belief.h), or stays at the last place while the view does not change. An image that shows nothing
/// makes no cell active: it is neither learned nor recalled.
///
/// A RecallVerifier can check recalls by image geometry. If it does not confirm a recall, a new template is learned
/// instead. A confirmed recall takes its relative heading from the geometry. The verifier is not called if the
/// recalled template was active at the previous event or is one of the 10 most recently learned: the robot is then
/// still at that place, so that the recall is no chance match with a distant place.
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

/// Confirms or rejects recalls by image geometry.
struct RecallVerifier {
  RecallVerifier() = default;
  RecallVerifier(const RecallVerifier&) = delete;
  RecallVerifier& operator=(const RecallVerifier&) = delete;
  virtual ~RecallVerifier();

  /// Pose of `image` relative to the place of view `view_id`; none if the image does not show that place.
  virtual std::optional<RecallGeometry> verify(Stamp stamp, const cv::Mat& image, std::uint32_t view_id) = 0;

  /// Called with every learned view and its image.
  virtual void learned(Stamp stamp, const cv::Mat& image, std::uint32_t view_id) = 0;
};

class LocalViewCells {
 public:
  /// @throws std::invalid_argument as LocalViewParams::validate and DescriptorRegistry::make do.
  explicit LocalViewCells(const LocalViewParams& params,
                          const DescriptorRegistry& registry = DescriptorRegistry::builtIn());

  /// Describes an image. To be called once for each image of the stream, in order. Types of image: see pixelFormat
  /// (grey.h). @throws std::invalid_argument for an unusable image, a crop or template that does not fit it, and an
  /// image of another size than the first one. The cells are then unchanged.
  View describe(const cv::Mat& image);

  /// Recalls or learns a view. @return the active view cell; kNoView if the image shows nothing.
  /// @param image of the view; only the verifier uses it.
  /// @param motion since the view before; only belief uses it.
  /// @param verifier of recalls; null: none.
  ViewEvent observe(Stamp stamp, const View& view, const cv::Mat& image, const ViewMotion& motion,
                    RecallVerifier* verifier = nullptr);

  /// describe() and observe(); each image counts as one step forward.
  ViewEvent observe(Stamp stamp, const cv::Mat& image, RecallVerifier* verifier = nullptr);

  /// Similarity of a view to each learned view: the graded activity V_i of equation (3). Empty for a view without an
  /// image.
  ViewLikeness likeness(const View& view);

  /// Allows another size of the next image. Learned views are kept: their size does not depend on it.
  void acceptAnotherSize() { image_size_ = cv::Size(); }

  /// To be called when the robot goes on from an unknown position (PlaceBelief::wakeUp).
  void wakeUp();

  /// Whether to learn views that are not recalled. If not, they make no view cell active (kNoView).
  void setLearning(bool learning) { learning_ = learning; }
  bool learning() const { return learning_; }

  /// Number of view cells, equal to the number of learned templates.
  std::size_t size() const { return pair_.matcher->size(); }

  const LocalViewParams& params() const { return params_; }

  /// Learned view `id` for display: 8-bit mono. @throws std::out_of_range.
  cv::Mat templateImage(std::uint32_t id) const;

  /// Learned view `id`, for merging maps. @throws std::out_of_range.
  View learned(std::uint32_t id) const { return pair_.matcher->learned(id); }

  /// The present view for display, learned or not: 8-bit mono; empty before the first event.
  const cv::Mat& viewImage() const { return view_image_; }

  /// Memory held for the learned templates.
  std::size_t memoryBytes() const { return pair_.matcher->memoryBytes() + belief_.memoryBytes(); }

  /// The belief of `vt_recall: belief`; empty under `nearest`.
  const PlaceBelief& belief() const { return belief_; }

  /// Result of the verifier for the present event, and the robot's distance ahead of the recalled place by the belief;
  /// none if there is neither.
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
  std::uint32_t known_before_ = 0;  ///< views that were known at the last wakeUp()
  ViewPair pair_;
  PlaceBelief belief_;
  View before_;                          // last view that showed something; only with belief
  cv::Size image_size_;                  // of all images, empty before the first
  std::optional<std::uint32_t> active_;  // view cell of the present event
  std::optional<RecallGeometry> geometry_;
  cv::Mat view_image_;
  ViewLikeness likeness_;
};

}  // namespace ratslam
