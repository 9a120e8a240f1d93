#include "ratslam/local_view/local_view_cells.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "ratslam/common/angles.h"
#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kRecentViews = 10;  // learned too recently for a recall of them to be a closed loop

/// An image of its own of 8-bit values that go row by row.
cv::Mat displayable(const std::vector<std::uint8_t>& bytes, const TemplateParams& params) {
  cv::Mat image(params.y_size, params.x_size, CV_8UC1);
  std::copy(bytes.begin(), bytes.end(), image.begin<std::uint8_t>());
  return image;
}

constexpr std::uint32_t kStateVersion = 1;

}  // namespace

RecallVerifier::~RecallVerifier() = default;

LocalViewCells::LocalViewCells(const LocalViewParams& params) : params_(params), matcher_(params) {}

bool LocalViewCells::isOldView(std::uint32_t id) const {
  return id != active_ && id + kRecentViews < matcher_.size();
}

double LocalViewCells::shiftAngle(int shift) const {
  return params_.panoramic ? wrapAngle(2.0 * kPi * shift / params_.view_template.x_size) : 0.0;
}

cv::Mat LocalViewCells::templateImage(std::uint32_t id) const {
  return displayable(matcher_.bytes(id), params_.view_template);
}

void LocalViewCells::save(State& state) const {
  state.setVersion(kStateVersion);
  matcher_.save(state);
  state.set("image_size", std::array<int, 2>{image_size_.width, image_size_.height});
  state.set("active", active_);
  state.set("geometry", geometry_);
  state.set("view",
            std::vector<std::uint8_t>(view_image_.begin<std::uint8_t>(), view_image_.end<std::uint8_t>()));
}

void LocalViewCells::load(const State& state) {
  state.requireVersion(kStateVersion);
  matcher_.load(state);
  const auto size = state.get<std::array<int, 2>>("image_size");
  image_size_ = cv::Size(size[0], size[1]);
  state.get("active", active_);
  state.get("geometry", geometry_);
  const auto view = state.get<std::vector<std::uint8_t>>("view");
  const auto pixels = static_cast<std::size_t>(params_.view_template.x_size * params_.view_template.y_size);
  view_image_ = view.size() == pixels ? displayable(view, params_.view_template) : cv::Mat();
}

ViewEvent LocalViewCells::observe(Stamp stamp, const cv::Mat& image, RecallVerifier* verifier) {
  if (!image_size_.empty() && !image.empty() && image.size() != image_size_) {
    std::ostringstream message;
    message << "image: its size changed from " << image_size_.width << " x " << image_size_.height << " to "
            << image.cols << " x " << image.rows << " pixels";
    throw std::invalid_argument(message.str());
  }
  const ViewTemplate view = makeViewTemplate(image, params_.view_template);
  const std::optional<TemplateMatch> match = matcher_.findBest(view);

  ViewEvent event;
  event.stamp = stamp;
  std::optional<RecallGeometry> geometry;
  if (match) event.error = match->error;
  bool recalled = match && match->error <= params_.match_threshold;
  if (recalled) {
    event.id = match->id;
    event.relative_rad = shiftAngle(match->shift);
    if (verifier != nullptr && isOldView(match->id)) {
      geometry = verifier->verify(stamp, image, match->id);
      recalled = geometry.has_value();
      if (recalled && geometry->inliers > 0) event.relative_rad = geometry->relative_rad;
      if (recalled && geometry->inliers == 0) geometry.reset();
    }
  }
  if (!recalled) {
    event.id = matcher_.add(view);
    event.learned = true;
    if (verifier != nullptr) verifier->learned(stamp, image, event.id);
  }
  image_size_ = image.size();
  active_ = event.id;
  geometry_ = geometry;
  view_image_ = displayable(quantised(view.values), params_.view_template);
  return event;
}

}  // namespace ratslam
