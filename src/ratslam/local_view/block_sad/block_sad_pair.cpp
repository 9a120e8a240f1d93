#include "ratslam/local_view/block_sad/block_sad_pair.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/local_view/block_sad/template_matcher.h"
#include "ratslam/local_view/block_sad/view_template.h"

namespace ratslam {
namespace {

/// A view whose blocks differ by less than one of 256 grey levels shows nothing. A single block counts as texture.
bool hasTexture(const BlockSums& blocks) {
  if (blocks.sums.size() == 1) return true;
  const auto [darkest, brightest] = std::minmax_element(blocks.sums.begin(), blocks.sums.end());
  return (*brightest - *darkest) * 255 >= blocks.full_scale;
}

/// The sums and the full scale. A learned view may end with its scale (BlockSadMatcher::learned).
View viewOf(const BlockSums& blocks) {
  View view;
  view.variants.emplace_back();
  std::vector<double>& values = view.variants.front().values;
  values.assign(blocks.sums.begin(), blocks.sums.end());
  values.push_back(static_cast<double>(blocks.full_scale));
  return view;
}

class BlockDescriptor : public ViewDescriptor {
 public:
  explicit BlockDescriptor(const TemplateParams& params) : params_(params) {}

  View describe(const cv::Mat& image) override {
    const BlockSums blocks = templateBlocks(image, params_);
    View view = viewOf(blocks);
    view.textured = hasTexture(blocks);
    return view;
  }

 private:
  TemplateParams params_;
};

class BlockSadMatcher : public ViewMatcher {
 public:
  explicit BlockSadMatcher(const LocalViewParams& params) : params_(params), search_(params) {}

  std::uint32_t add(const View& view) override { return search_.add(templateOf(view)); }
  std::size_t size() const override { return search_.size(); }

  std::optional<ViewMatch> findBest(const View& view) override {
    const std::optional<TemplateMatch> best = search_.findBest(templateOf(view));
    if (!best) return std::nullopt;
    return matchOf(*best);
  }

  ViewMatch compareWith(const View& view, std::uint32_t id) override {
    return matchOf(search_.compareWith(templateOf(view), id));
  }

  View learned(std::uint32_t id) const override {
    const BlockSums blocks = search_.blocks(id);
    View view = viewOf(blocks);
    // Where clamped sums no longer tell the scale, it is the last value.
    if (const double scale = search_.scale(id); scaleOf(blocks, params_.view_template) != scale)
      view.variants.front().values.push_back(scale);
    return view;
  }

  void compareAll(const View& view, ViewLikeness& likeness) override {
    likeness.variants = 1;
    likeness.priors.assign(1, 1.0);
    likeness.places = search_.size();
    search_.likeness(templateOf(view), likeness.values);
  }

  /// The difference of the views relative to the threshold for the same place.
  double novelty(const View& view, const View& before) const override {
    const std::vector<double> a = templateOf(view).values;
    const std::vector<double> b = templateOf(before).values;
    double difference = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) difference += std::abs(a[i] - b[i]);
    difference /= static_cast<double>(a.size());
    return difference < params_.match_threshold ? difference / params_.match_threshold : 1.0;
  }

  cv::Mat picture(std::uint32_t id) const override { return displayable(search_.bytes(id)); }
  cv::Mat picture(const View& view) const override { return displayable(quantised(templateOf(view).values)); }

  std::size_t memoryBytes() const override { return search_.memoryBytes(); }
  void save(State& state) const override { search_.save(state); }
  void load(const State& state) override { search_.load(state); }

 private:
  ViewTemplate templateOf(const View& view) const {
    const std::vector<double>& values = view.variants.front().values;
    BlockSums blocks;
    blocks.columns = params_.view_template.x_size;
    blocks.rows = params_.view_template.y_size;
    const std::ptrdiff_t count = std::ptrdiff_t{blocks.columns} * blocks.rows;
    const auto full_scale = values.begin() + std::min(count, std::ptrdiff_t(values.size()) - 1);
    blocks.sums.assign(values.begin(), full_scale);
    blocks.full_scale = static_cast<std::uint64_t>(*full_scale);
    const bool says_scale = full_scale + 1 != values.end();
    const double scale = says_scale ? values.back() : scaleOf(blocks, params_.view_template);
    return makeViewTemplate(std::move(blocks), scale, params_.view_template);
  }

  ViewMatch matchOf(const TemplateMatch& match) const {
    const double turned =
        params_.panoramic ? wrapAngle(2.0 * kPi * match.shift / params_.view_template.x_size) : 0.0;
    return {match.id, turned, match.error, match.error <= params_.match_threshold};
  }

  /// Copies 8-bit values, row by row, to an image.
  cv::Mat displayable(const std::vector<std::uint8_t>& bytes) const {
    cv::Mat image(params_.view_template.y_size, params_.view_template.x_size, CV_8UC1);
    std::copy(bytes.begin(), bytes.end(), image.begin<std::uint8_t>());
    return image;
  }

  LocalViewParams params_;
  TemplateMatcher search_;
};

}  // namespace

ViewPair makeBlockSadPair(const LocalViewParams& params) {
  return {std::make_unique<BlockDescriptor>(params.view_template), std::make_unique<BlockSadMatcher>(params)};
}

}  // namespace ratslam
