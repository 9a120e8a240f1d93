/// What an image looks like, as numbers of a fixed count: one half of the seam between the local view cells
/// and the ways of seeing. The other half, matcher.h, searches what the descriptor makes.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace ratslam {

class State;

/// A view as it looks from one direction, or from a little beside the camera.
struct ViewVariant {
  std::vector<double> values;  ///< as many for every image
  double relative_rad = 0.0;   ///< how far the camera would be turned for the view to look like this [rad]
  double prior = 1.0;          ///< how likely it is, before anything is known; those of a view sum to 1
};

struct View {
  /// The first is the image as it is, and is what is learned. The others are compared with learned views,
  /// too: the same image moved sideways, for another lane or heading.
  std::vector<ViewVariant> variants;
  /// False where there is nothing to see: such a view is neither learned nor recalled.
  bool textured = true;
};

class ViewDescriptor {
 public:
  ViewDescriptor() = default;
  ViewDescriptor(const ViewDescriptor&) = delete;
  ViewDescriptor& operator=(const ViewDescriptor&) = delete;
  virtual ~ViewDescriptor();

  /// A descriptor may adapt to what it sees: it is to be shown each image of a stream once, in order.
  /// @throws std::invalid_argument for an image that it cannot describe; it is then as before.
  virtual View describe(const cv::Mat& image) = 0;

  /// What it has adapted to; nothing, by default.
  virtual void save(State& state) const;
  virtual void load(const State& state);
};

}  // namespace ratslam
