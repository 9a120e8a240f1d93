/// Registry of the view descriptors by name, for `vt_descriptor`.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "ratslam/local_view/descriptor.h"
#include "ratslam/local_view/local_view_params.h"
#include "ratslam/local_view/matcher.h"

namespace ratslam {

/// A descriptor and the matcher for its values.
struct ViewPair {
  std::unique_ptr<ViewDescriptor> descriptor;
  std::unique_ptr<ViewMatcher> matcher;
};

class DescriptorRegistry {
 public:
  /// @throws std::invalid_argument for bad parameters.
  using Maker = std::function<ViewPair(const LocalViewParams&)>;

  /// The pairs that come with the library.
  static DescriptorRegistry builtIn();

  void add(const std::string& name, Maker maker) { makers_[name] = std::move(maker); }

  /// Makes the pair that vt_descriptor names. @throws std::invalid_argument listing the known names, and as the pair's
  /// maker does.
  ViewPair make(const LocalViewParams& params) const;

 private:
  std::map<std::string, Maker> makers_;
};

}  // namespace ratslam
