#include "ratslam/local_view/descriptor_registry.h"

#include "ratslam/local_view/block_sad/block_sad_pair.h"
#include "ratslam/local_view/orientation/orientation_pair.h"

namespace ratslam {

ViewDescriptor::~ViewDescriptor() = default;
void ViewDescriptor::save(State& /*state*/) const {}
void ViewDescriptor::load(const State& /*state*/) {}
ViewMatcher::~ViewMatcher() = default;

DescriptorRegistry DescriptorRegistry::builtIn() {
  DescriptorRegistry registry;
  registry.add("blocks", makeBlockSadPair);
  registry.add("orientation", makeOrientationPair);
  return registry;
}

ViewPair DescriptorRegistry::make(const LocalViewParams& params) const {
  const auto found = makers_.find(params.descriptor);
  if (found != makers_.end()) return found->second(params);
  std::string names;
  for (const auto& [name, maker] : makers_) names += (names.empty() ? "" : " or ") + name;
  throwBadValue("vt_descriptor", params.descriptor, "it must be " + names);
}

}  // namespace ratslam
