#include "ratslam/local_view/block_sad/template_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "ratslam/common/state.h"
#include "ratslam/simd/sad_kernels.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kNoCandidate = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kBatchGroups = 64;  // searched at once, so that the next ones can be prefetched

const LocalViewParams& validated(const LocalViewParams& params) {
  params.validate();
  return params;
}

std::uint32_t smallestOfGroup(const std::uint32_t* values) {
  std::uint32_t smallest = values[0];
  for (std::size_t lane = 1; lane < kGroupLanes; ++lane) smallest = std::min(smallest, values[lane]);
  return smallest;
}

/// Sum of the changes of the values by rounding to 8 bits [levels], rounded up, and 1 for the rounding of sums of doubles.
std::uint32_t roundingOf(const std::vector<double>& values) {
  // Whole numbers allow the compiler to vectorise the sum.
  constexpr int kParts = 1 << 16;
  std::int64_t parts = 0;
  for (const double value : values) {
    parts += static_cast<std::int32_t>(std::abs(255.0 * value - quantised(value)) * kParts) + 1;
  }
  return static_cast<std::uint32_t>(parts / kParts) + 2;
}

/// Sum of absolute differences of a view and a template at one shift, row by row and column by column.
template <typename Sum, typename Value>
Sum absoluteDifferences(const std::vector<Value>& view, const std::vector<Value>& learned, int shift,
                        const LocalViewParams& params) {
  using Difference = decltype(Value() - Value());
  const std::ptrdiff_t columns = params.view_template.x_size;
  const std::ptrdiff_t compared = params.comparedColumns();
  const std::ptrdiff_t unwrapped = std::min(compared, columns - shift);
  const Value* view_row = view.data() + (params.panoramic ? 0 : params.shift_match);
  const Value* learned_row = learned.data() + shift;
  Sum sum = 0;
  const auto add = [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t turn) {
    for (std::ptrdiff_t x = begin; x < end; ++x) {
      sum += static_cast<Sum>(std::abs(Difference{view_row[x]} - Difference{learned_row[x - turn]}));
    }
  };
  for (int y = 0; y < params.view_template.y_size; ++y) {
    add(0, unwrapped, 0);
    add(unwrapped, compared, columns);
    view_row += columns;
    learned_row += columns;
  }
  return sum;
}

/// The better match has the lower rank.
std::tuple<double, std::uint32_t, int> rank(const TemplateMatch& match) {
  return {match.error, match.id, match.shift};
}

}  // namespace

TemplateMatcher::TemplateMatcher(const LocalViewParams& params, SimdLevel level)
    : params_(validated(params)),
      level_(level),
      compared_values_(static_cast<std::size_t>(params.comparedColumns() * params.view_template.y_size)),
      coarse_(BlockGrid::coarse(params), level),
      fine_(BlockGrid::ofValues(params), level) {}

void TemplateMatcher::checkSize(const ViewTemplate& view) const {
  const TemplateParams& expected = params_.view_template;
  if (view.blocks.columns == expected.x_size && view.blocks.rows == expected.y_size) return;
  std::ostringstream message;
  message << "view template: its size is " << view.blocks.columns << " x " << view.blocks.rows << ", not "
          << expected.x_size << " x " << expected.y_size;
  throw std::invalid_argument(message.str());
}

std::uint32_t TemplateMatcher::add(const ViewTemplate& learned) {
  checkSize(learned);
  append(learned.values, learned.mean, PackedTemplate(learned, params_.view_template));
  return static_cast<std::uint32_t>(size() - 1);
}

void TemplateMatcher::append(const std::vector<double>& values, double mean, PackedTemplate packed) {
  const std::size_t id = size();
  coarse_.add(values);
  fine_.add(values);
  if (id % kGroupLanes == 0) means_.resize(id + kGroupLanes, std::numeric_limits<double>::infinity());
  means_[id] = mean;
  if (id % kGroupLanes == 0) mean_ranges_.push_back({mean, mean});
  mean_ranges_.back().low = std::min(mean_ranges_.back().low, mean);
  mean_ranges_.back().high = std::max(mean_ranges_.back().high, mean);
  rounding_.push_back(roundingOf(values));
  largest_rounding_ = std::max(largest_rounding_, rounding_.back());
  packed_.push_back(std::move(packed));
}

void TemplateMatcher::save(State& state) const {
  std::vector<Row> rows;
  rows.reserve(size());
  for (std::uint32_t id = 0; id < size(); ++id) rows.push_back({means_[id], bytes(id), packed_[id].record()});
  state.set("templates", rows);
}

void TemplateMatcher::load(const State& state) {
  TemplateMatcher loaded(params_, level_);
  const auto count = static_cast<std::size_t>(params_.view_template.x_size * params_.view_template.y_size);
  for (const Row& row : state.get<std::vector<Row>>("templates")) {
    if (row.values.size() != count) {
      throw std::runtime_error("state " + state.path() + "/templates: a template has " +
                               std::to_string(row.values.size()) + " values, not " + std::to_string(count));
    }
    PackedTemplate packed(row.exact, count);
    const std::vector<double> values = packed.values(row.values, params_.view_template);
    loaded.append(values, row.mean, std::move(packed));
  }
  *this = std::move(loaded);
}

std::vector<std::uint8_t> TemplateMatcher::bytes(std::uint32_t id) const {
  if (id >= size()) throw std::out_of_range("view template: there is none of id " + std::to_string(id));
  return fine_.bytes(id);
}

std::vector<double> TemplateMatcher::values(std::uint32_t id) const {
  return packed_.at(id).values(bytes(id), params_.view_template);
}

BlockSums TemplateMatcher::blocks(std::uint32_t id) const {
  return packed_.at(id).blocks(bytes(id), params_.view_template);
}

std::optional<TemplateMatch> TemplateMatcher::findBest(const ViewTemplate& view) {
  checkSize(view);
  coarse_.setView(view.values);
  const std::optional<std::size_t> most_likely = boundCoarsely(view.mean);
  if (!most_likely) return std::nullopt;
  fine_.setView(view.values);
  view_bytes_ = quantised(view.values);
  collectCandidates(*most_likely, roundingOf(view.values));
  std::optional<TemplateMatch> best;
  for (const Candidate& candidate : candidates_) refine(candidate, view.values, best);
  return best;
}

TemplateMatch TemplateMatcher::compareWith(const ViewTemplate& view, std::uint32_t id) {
  checkSize(view);
  view_bytes_ = quantised(view.values);
  std::optional<TemplateMatch> best;
  if (id >= size()) throw std::out_of_range("view template: there is none of id " + std::to_string(id));
  refine({0, rounding_[id] + roundingOf(view.values), id}, view.values, best);
  return *best;
}

void TemplateMatcher::likeness(const ViewTemplate& view, std::vector<float>& values) {
  checkSize(view);
  fine_.setView(view.values);
  std::vector<std::uint32_t> sads(fine_.groupCount() * kGroupLanes);
  fine_.smallestSads(0, fine_.groupCount(), sads.data());
  const float scale = -1.0F / (255.0F * static_cast<float>(compared_values_));
  values.resize(size());
  std::transform(sads.begin(), sads.begin() + static_cast<std::ptrdiff_t>(size()), values.begin(),
                 [scale](std::uint32_t sad) { return scale * static_cast<float>(sad); });
}

/// Fills coarse_sads_, with kNoCandidate for templates outside the mean gate. @return the id of the smallest. The range
/// of their means excludes or includes most groups as a whole.
std::optional<std::size_t> TemplateMatcher::boundCoarsely(double view_mean) {
  const double gate = params_.meanGate();
  const auto group_excluded = [&](std::size_t group) {
    const MeanRange& range = mean_ranges_[group];
    return std::abs(view_mean - std::clamp(view_mean, range.low, range.high)) > gate;
  };
  const auto group_included = [&](std::size_t group) {
    const MeanRange& range = mean_ranges_[group];
    return (group + 1) * kGroupLanes <= size() && std::abs(view_mean - range.low) <= gate &&
           std::abs(view_mean - range.high) <= gate;
  };
  const std::size_t groups = coarse_.groupCount();
  coarse_sads_.assign(groups * kGroupLanes, kNoCandidate);
  std::uint32_t smallest = kNoCandidate;
  std::size_t most_likely = 0;
  for (std::size_t first = 0; first < groups;) {
    if (group_excluded(first)) {
      ++first;
      continue;
    }
    std::size_t last = first + 1;
    while (last < groups && last - first < kBatchGroups && !group_excluded(last)) ++last;
    coarse_.smallestSads(first, last, coarse_sads_.data() + first * kGroupLanes);
    for (; first < last; ++first) {
      std::uint32_t* sads = coarse_sads_.data() + first * kGroupLanes;
      if (!group_included(first)) {
        const double* means = means_.data() + first * kGroupLanes;
        for (std::size_t lane = 0; lane < kGroupLanes; ++lane) {
          if (!(std::abs(view_mean - means[lane]) <= gate)) sads[lane] = kNoCandidate;
        }
      }
      const std::uint32_t of_group = smallestOfGroup(sads);
      if (of_group >= smallest) continue;
      smallest = of_group;
      most_likely =
          static_cast<std::size_t>(std::find(sads, sads + kGroupLanes, of_group) - coarse_sads_.data());
    }
  }
  if (smallest == kNoCandidate) return std::nullopt;
  return most_likely;
}

/// Fills candidates_ with every template that may be the best, the smallest 8-bit SAD first.
void TemplateMatcher::collectCandidates(std::size_t most_likely, std::uint32_t view_rounding) {
  const std::uint64_t coarse_rounding =
      coarse_.grid().mostCompared() + 1;  // half a level for view and template each
  const std::uint64_t in_block = coarse_.grid().valuesInBlock();
  std::uint64_t ceiling = kNoCandidate - 1;  // upper bound of 255 times the best sum
  std::uint64_t coarse_limit = kNoCandidate - 1;
  std::array<std::uint32_t, kBatchGroups * kGroupLanes> sads{};
  const auto search_groups = [&](std::size_t first, std::size_t last, bool collect) {
    fine_.smallestSads(first, last, sads.data());
    for (std::size_t group = first; group < last; ++group) {
      const std::uint32_t* group_sads = sads.data() + (group - first) * kGroupLanes;
      if (smallestOfGroup(group_sads) > ceiling + largest_rounding_ + view_rounding) continue;
      for (std::size_t lane = 0; lane < kGroupLanes; ++lane) {
        const std::size_t id = group * kGroupLanes + lane;
        const std::uint32_t sad = group_sads[lane];
        if (coarse_sads_[id] > coarse_limit) continue;
        const std::uint32_t rounding = rounding_[id] + view_rounding;
        if (sad > ceiling + rounding) continue;
        if (collect) candidates_.push_back({sad, rounding, static_cast<std::uint32_t>(id)});
        if (sad + std::uint64_t{rounding} >= ceiling) continue;
        ceiling = sad + std::uint64_t{rounding};
        coarse_limit = std::min<std::uint64_t>(coarse_limit, ceiling / in_block + coarse_rounding);
      }
    }
  };
  const auto group_excluded = [&](std::size_t group) {
    return smallestOfGroup(coarse_sads_.data() + group * kGroupLanes) > coarse_limit;
  };
  candidates_.clear();
  search_groups(most_likely / kGroupLanes, most_likely / kGroupLanes + 1, false);
  const std::size_t groups = fine_.groupCount();
  for (std::size_t first = 0; first < groups;) {
    if (group_excluded(first)) {
      ++first;
      continue;
    }
    std::size_t last = first + 1;
    while (last < groups && last - first < kBatchGroups && !group_excluded(last)) ++last;
    search_groups(first, last, true);
    first = last;
  }
  const auto hopeless = [&](const Candidate& c) { return c.sad > ceiling + c.rounding; };
  candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), hopeless), candidates_.end());
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
    return a.sad != b.sad ? a.sad < b.sad : a.id < b.id;
  });
}

/// Replaces the best match by the candidate if that is better.
void TemplateMatcher::refine(const Candidate& candidate, const std::vector<double>& view,
                             std::optional<TemplateMatch>& best) {
  const auto hopeless = [&](std::uint32_t sad) {
    return best && sad > 255.0 * best->error * static_cast<double>(compared_values_) + candidate.rounding;
  };
  if (hopeless(candidate.sad)) return;
  if (best && best->error == 0.0 && candidate.id > best->id) return;  // no error is smaller
  const std::vector<std::uint8_t> bytes = fine_.bytes(candidate.id);
  const std::vector<double> learned = packed_[candidate.id].values(bytes, params_.view_template);
  shift_sads_.clear();
  for (int i = 0; i < params_.shiftCount(); ++i) {
    shift_sads_.push_back(
        absoluteDifferences<std::uint32_t>(view_bytes_, bytes, i * params_.step_match, params_));
  }
  const auto compare = [&](std::size_t shift_number) {
    TemplateMatch match{candidate.id, static_cast<int>(shift_number) * params_.step_match, 0.0};
    match.error = absoluteDifferences<double>(view, learned, match.shift, params_) /
                  static_cast<double>(compared_values_);
    if (!best || rank(match) < rank(*best)) best = match;
  };
  // Begin with the most likely shift, which then excludes most others.
  const auto first = static_cast<std::size_t>(std::min_element(shift_sads_.begin(), shift_sads_.end()) -
                                              shift_sads_.begin());
  compare(first);
  for (std::size_t i = 0; i < shift_sads_.size(); ++i) {
    if (i != first && !hopeless(shift_sads_[i])) compare(i);
  }
}

std::size_t TemplateMatcher::memoryBytes() const {
  std::size_t bytes = coarse_.memoryBytes() + fine_.memoryBytes() + means_.capacity() * sizeof(double) +
                      mean_ranges_.capacity() * sizeof(MeanRange) +
                      rounding_.capacity() * sizeof(std::uint32_t) +
                      (packed_.capacity() - packed_.size()) * sizeof(PackedTemplate);
  for (const PackedTemplate& packed : packed_) bytes += packed.memoryBytes();
  return bytes;
}

}  // namespace ratslam
