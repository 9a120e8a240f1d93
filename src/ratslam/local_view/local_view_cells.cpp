#include "ratslam/local_view/local_view_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "ratslam/common/angles.h"
#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kRecentViews = 10;  // newest views, whose recall closes no loop

constexpr std::uint32_t kStateVersion = 9;

}  // namespace

RecallVerifier::~RecallVerifier() = default;

LocalViewCells::LocalViewCells(const LocalViewParams& params, const DescriptorRegistry& registry)
    : params_(params), pair_(registry.make(params)), belief_(params.panoramic) {
  params.validate();
}

bool LocalViewCells::isOldView(std::uint32_t id) const {
  return id != active_ && (id < known_before_ || id + kRecentViews < size());
}

void LocalViewCells::wakeUp() {
  belief_.wakeUp();
  before_.variants.clear();  // the next view is new even if it equals the last one, as at the dock
  active_.reset();           // nothing says that the robot is still there
  known_before_ = static_cast<std::uint32_t>(size());
}

cv::Mat LocalViewCells::templateImage(std::uint32_t id) const { return pair_.matcher->picture(id); }

View LocalViewCells::describe(const cv::Mat& image) {
  if (!image_size_.empty() && !image.empty() && image.size() != image_size_) {
    std::ostringstream message;
    message << "image: its size changed from " << image_size_.width << " x " << image_size_.height << " to "
            << image.cols << " x " << image.rows << " pixels";
    throw std::invalid_argument(message.str());
  }
  View view = pair_.descriptor->describe(image);
  image_size_ = image.size();
  return view;
}

LocalViewCells::Candidate LocalViewCells::nearest(const View& view) {
  const std::optional<ViewMatch> match = pair_.matcher->findBest(view);
  if (!match) return {};
  return {match->id, match->relative_rad, match->error, match->same_place};
}

/// Heading now relative to that at the claimed place: the mean over the view's variants, or, with a single variant, the
/// matcher's result.
double LocalViewCells::turnOf(const View& view, const PlaceClaim& claim, const ViewMatch& match) {
  if (view.variants.size() != claim.variant_weights.size() || view.variants.size() == 1) {
    return match.relative_rad;
  }
  double sine = 0.0;
  double cosine = 0.0;
  for (std::size_t v = 0; v < view.variants.size(); ++v) {
    sine += claim.variant_weights[v] * std::sin(view.variants[v].relative_rad);
    cosine += claim.variant_weights[v] * std::cos(view.variants[v].relative_rad);
  }
  return std::atan2(sine, cosine);
}

/// Novelty of a view relative to the last one that showed something.
double LocalViewCells::noveltyOf(const View& view) {
  if (!view.textured) return 0.0;
  const double novelty = before_.variants.empty() ? 1.0 : pair_.matcher->novelty(view, before_);
  before_.variants.assign(1, view.variants.front());
  return novelty;
}

LocalViewCells::Candidate LocalViewCells::mostBelieved(const View& view) {
  pair_.matcher->compareAll(view, likeness_);
  const std::optional<PlaceClaim> claim = belief_.weigh(likeness_, belief_.leftBehind(likeness_));
  if (claim && claim->confidence > PlaceBelief::kClaim) {
    const ViewMatch match = pair_.matcher->compareWith(view, claim->place);
    return {claim->place, turnOf(view, *claim, match), match.error, true, claim->ahead};
  }
  if (!active_) return {};
  const ViewMatch still = pair_.matcher->compareWith(view, *active_);
  return {still.id, still.relative_rad, still.error, still.same_place};
}

ViewEvent LocalViewCells::observe(Stamp stamp, const View& view, const cv::Mat& image,
                                  const ViewMotion& motion, RecallVerifier* verifier) {
  if (params_.recall.believes()) belief_.move(motion, noveltyOf(view));
  if (!view.textured) {
    ViewEvent nothing;
    nothing.stamp = stamp;
    nothing.id = kNoView;
    return nothing;
  }
  const Candidate candidate = params_.recall.believes() ? mostBelieved(view) : nearest(view);
  ViewEvent event;
  event.stamp = stamp;
  event.error = candidate.error;
  std::optional<RecallGeometry> geometry;
  bool recalled = candidate.recalled;
  if (recalled) {
    event.id = candidate.id;
    event.relative_rad = candidate.relative_rad;
    if (verifier != nullptr && isOldView(candidate.id)) {
      geometry = verifier->verify(stamp, image, candidate.id);
      recalled = geometry.has_value();
      if (recalled && geometry->inliers > 0) event.relative_rad = geometry->relative_rad;
      if (recalled && geometry->inliers == 0) geometry.reset();
    }
  }
  if (recalled && candidate.ahead != 0.0) {
    if (!geometry) geometry.emplace();
    geometry->ahead = candidate.ahead;
  }
  if (!recalled && !learning_) {
    event.id = kNoView;
  } else if (!recalled) {
    event.id = pair_.matcher->add(view);
    event.learned = true;
    if (verifier != nullptr) verifier->learned(stamp, image, event.id);
  }
  if (params_.recall.believes() && event.seen()) belief_.arrive(event.id, learning_);
  active_ = event.seen() ? std::optional<std::uint32_t>(event.id) : std::nullopt;
  geometry_ = geometry;
  view_image_ = pair_.matcher->picture(view);
  return event;
}

ViewEvent LocalViewCells::observe(Stamp stamp, const cv::Mat& image, RecallVerifier* verifier) {
  return observe(stamp, describe(image), image, ViewMotion::oneStep(), verifier);
}

ViewLikeness LocalViewCells::likeness(const View& view) {
  ViewLikeness likeness;
  if (!view.variants.empty()) pair_.matcher->compareAll(view, likeness);
  return likeness;
}

void LocalViewCells::save(State& state) const {
  state.setVersion(kStateVersion);
  pair_.matcher->save(state);
  pair_.descriptor->save(state.child("descriptor"));
  state.child("belief").write(belief_);
  state.set("before", before_.variants.empty() ? std::vector<double>() : before_.variants.front().values);
  state.set("image_size", std::array<int, 2>{image_size_.width, image_size_.height});
  state.set("active", active_);
  state.set("known_before", known_before_);
  state.set("geometry", geometry_);
  state.set("view_size", std::array<int, 2>{view_image_.cols, view_image_.rows});
  std::vector<std::uint8_t> view;  // an empty image has no iterators
  if (!view_image_.empty()) view.assign(view_image_.begin<std::uint8_t>(), view_image_.end<std::uint8_t>());
  state.set("view", view);
}

void LocalViewCells::load(const State& state) {
  state.requireVersion(kStateVersion);
  pair_.matcher->load(state);
  pair_.descriptor->load(state.child("descriptor"));
  state.child("belief").read(belief_);
  before_.variants.clear();
  const auto before = state.get<std::vector<double>>("before");
  if (!before.empty()) before_.variants.push_back({before, 0.0, 1.0});
  const auto size = state.get<std::array<int, 2>>("image_size");
  image_size_ = cv::Size(size[0], size[1]);
  state.get("active", active_);
  state.get("known_before", known_before_);
  state.get("geometry", geometry_);
  const auto view_size = state.get<std::array<int, 2>>("view_size");
  const auto view = state.get<std::vector<std::uint8_t>>("view");
  view_image_ = cv::Mat();
  if (view_size[0] > 0 && view.size() == static_cast<std::size_t>(view_size[0] * view_size[1])) {
    view_image_ = cv::Mat(view_size[1], view_size[0], CV_8UC1);
    std::copy(view.begin(), view.end(), view_image_.begin<std::uint8_t>());
  }
}

}  // namespace ratslam
