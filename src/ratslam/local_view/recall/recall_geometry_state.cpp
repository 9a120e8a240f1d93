#include <algorithm>
#include <array>
#include <stdexcept>

#include "ratslam/common/state.h"
#include "ratslam/common/state_image.h"
#include "ratslam/local_view/recall/recall_geometry_estimator.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kStateVersion = 2;

}  // namespace

void RecallGeometryEstimator::Frame::save(State& state) const {
  state.set("stamp", stamp);
  setImage(state, grey);
}

void RecallGeometryEstimator::Frame::load(const State& state) {
  state.get("stamp", stamp);
  grey = getImage(state);
  features.reset();
}

void RecallGeometryEstimator::Template::save(State& state) const {
  state.set("stamp", stamp);
  state.set("bearings", features.bearings);
  state.set("sigmas", features.sigmas);
  setImage(state.child("descriptors"), features.descriptors);
  state.set("companion", companion);
}

void RecallGeometryEstimator::Template::load(const State& state) {
  state.get("stamp", stamp);
  state.get("bearings", features.bearings);
  state.get("sigmas", features.sigmas);
  features.descriptors = getImage(state.child("descriptors"));
  state.get("companion", companion);
  const std::size_t count = features.size();
  bool fits = features.sigmas.size() == count && features.descriptors.rows == static_cast<int>(count) &&
              (count == 0 || features.descriptors.cols == kRecallDescriptorBytes);
  if (companion) {
    fits = fits && companion->bearings.size() == count && companion->inverse_depths.size() == count &&
           companion->sigmas.size() == count;
  }
  if (!fits) throw std::runtime_error("state " + state.path() + ": its features do not belong together");
}

void RecallGeometryEstimator::save(State& state) const {
  state.setVersion(kStateVersion);
  state.set("image_size", std::array<int, 2>{camera_.width, camera_.height});
  state.setEach("frames", std::vector<Frame>(ring_.begin(), ring_.end()));
  std::vector<std::uint32_t> ids;
  State& templates = state.child("templates");
  for (const auto& [id, each] : templates_) {
    each.save(templates.child(std::to_string(ids.size())));
    ids.push_back(id);
  }
  state.set("template_ids", ids);
}

void RecallGeometryEstimator::load(const State& state) {
  state.requireVersion(kStateVersion);
  std::deque<Frame> ring;
  state.forEach("frames", [&ring](const State& frame, std::size_t) {
    ring.emplace_back();
    ring.back().load(frame);
  });
  std::map<std::uint32_t, Template> templates;
  const auto ids = state.get<std::vector<std::uint32_t>>("template_ids");
  for (std::size_t i = 0; i < ids.size(); ++i) {
    templates[ids[i]].load(state.child("templates").child(std::to_string(i)));
  }
  ring_ = std::move(ring);
  templates_ = std::move(templates);
}

}  // namespace ratslam
