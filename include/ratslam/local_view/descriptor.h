/// Interface of view descriptors: a descriptor turns an image into a fixed number of values. A matcher (matcher.h)
/// compares them. Together they are the exchangeable part of the local view cells.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace ratslam {

class State;

/// A view from one direction, or from a position a little beside the camera.
struct ViewVariant {
  std::vector<double> values;  ///< the same number for every image
  double relative_rad = 0.0;   ///< turn of the camera that would make the view look like this variant [rad]
  double prior = 1.0;          ///< prior probability; those of a view sum to 1
};

struct View {
  /// The first one is the unchanged image, which is learned. The others are the same image moved sideways, for
  /// another lane or heading. All of them are compared with learned views.
  std::vector<ViewVariant> variants;
  /// False if the image shows nothing: such a view is neither learned nor recalled.
  bool textured = true;

  template <class Fields>
  void stateFields(Fields&& fields) {
    std::vector<double> values;
    std::vector<double> turns;
    std::vector<double> priors;
    for (const ViewVariant& variant : variants) {
      values.insert(values.end(), variant.values.begin(), variant.values.end());
      turns.push_back(variant.relative_rad);
      priors.push_back(variant.prior);
    }
    fields("textured", textured);
    fields("values", values);
    fields("turns", turns);
    fields("priors", priors);
    variants.resize(turns.size());
    for (std::size_t i = 0; i < turns.size(); ++i) {
      const auto length = static_cast<std::ptrdiff_t>(values.size() / turns.size());
      const auto first = values.begin() + static_cast<std::ptrdiff_t>(i) * length;
      variants[i] = {{first, first + length}, turns[i], priors.at(i)};
    }
  }
};

class ViewDescriptor {
 public:
  ViewDescriptor() = default;
  ViewDescriptor(const ViewDescriptor&) = delete;
  ViewDescriptor& operator=(const ViewDescriptor&) = delete;
  virtual ~ViewDescriptor();

  /// Describes an image. A descriptor may adapt to the images: so call this once for each image, in order.
  /// @throws std::invalid_argument for an image that it cannot describe. The descriptor is then unchanged.
  virtual View describe(const cv::Mat& image) = 0;

  /// Saves the adaptation; by default nothing.
  virtual void save(State& state) const;
  virtual void load(const State& state);
};

}  // namespace ratslam
