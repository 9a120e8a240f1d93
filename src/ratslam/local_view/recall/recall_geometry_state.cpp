#include <algorithm>
#include <stdexcept>

#include "ratslam/common/state.h"
#include "ratslam/common/state_image.h"
#include "ratslam/local_view/recall/recall_geometry_estimator.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kStateVersion = 4;

}  // namespace

void RecallGeometryEstimator::Frame::save(State& state) const {
  state.set("stamp", stamp);
  setPhoto(state, "grey", grey);
}

void RecallGeometryEstimator::Frame::load(const State& state) {
  state.get("stamp", stamp);
  grey = getImage(state.child("grey"));
  features.reset();
}

struct RecallGeometryEstimator::TemplateRow {
  std::uint32_t id = 0;
  Stamp stamp = 0;
  std::vector<Eigen::Vector2f> bearings;
  std::vector<float> sigmas;
  std::vector<std::uint8_t> descriptors;  ///< kRecallDescriptorBytes per feature
  std::optional<Companion> companion;

  static TemplateRow of(std::uint32_t id, const Template& each) {
    TemplateRow row{id, each.stamp, each.features.bearings, each.features.sigmas, {}, each.companion};
    for (int feature = 0; feature < each.features.descriptors.rows; ++feature) {
      const auto* bytes = each.features.descriptors.ptr<std::uint8_t>(feature);
      row.descriptors.insert(row.descriptors.end(), bytes, bytes + kRecallDescriptorBytes);
    }
    return row;
  }
  /// @param table  of this row. @throws std::runtime_error naming it if the sizes of the features do not fit together
  std::shared_ptr<const Template> original(const State& table) const {
    const std::size_t count = bearings.size();
    bool fits = sigmas.size() == count && descriptors.size() == count * kRecallDescriptorBytes;
    if (companion) {
      fits = fits && companion->bearings.size() == count && companion->inverse_depths.size() == count &&
             companion->sigmas.size() == count;
    }
    if (!fits) {
      throw std::runtime_error("state " + table.path() + ": the features of template " + std::to_string(id) +
                               " do not belong together");
    }
    Template each{stamp, {bearings, sigmas, {}}, companion};
    each.features.descriptors.create(static_cast<int>(count), kRecallDescriptorBytes, CV_8U);
    std::copy(descriptors.begin(), descriptors.end(), each.features.descriptors.data);
    return std::make_shared<const Template>(std::move(each));
  }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("id", id);
    fields("stamp", stamp);
    fields("bearings", bearings);
    fields("sigmas", sigmas);
    fields("descriptors", descriptors);
    fields("companion", companion);
  }
};

void RecallGeometryEstimator::save(State& state) const {
  state.setVersion(kStateVersion);
  state.setEach("frames", std::vector<Frame>(ring_.begin(), ring_.end()));
  state.setLater("templates", [templates = templates_](State& list) {
    std::vector<TemplateRow> rows;
    rows.reserve(templates.size());
    for (const auto& [id, each] : templates) rows.push_back(TemplateRow::of(id, *each));
    list.set("rows", rows);
  });
}

void RecallGeometryEstimator::load(const State& state) {
  state.requireVersion(kStateVersion);
  std::deque<Frame> ring;
  state.forEach("frames", [&ring](const State& frame, std::size_t) {
    ring.emplace_back();
    ring.back().load(frame);
  });
  // The map may have been made by another camera. Its templates are bearings, but its images do not fit this one.
  const cv::Size size(camera_.width, camera_.height);
  const auto another = [&size](const Frame& frame) { return frame.grey.size() != size; };
  ring.erase(std::remove_if(ring.begin(), ring.end(), another), ring.end());
  const State& list = state.child("templates");
  std::map<std::uint32_t, std::shared_ptr<const Template>> templates;
  for (const TemplateRow& row : list.get<std::vector<TemplateRow>>("rows")) {
    templates[row.id] = row.original(list);
  }
  ring_ = std::move(ring);
  templates_ = std::move(templates);
}

}  // namespace ratslam
