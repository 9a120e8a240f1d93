/// Search of the learned template most like a view (MODEL section 1, step 5).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ratslam/local_view/local_view_params.h"
#include "ratslam/local_view/view_template.h"

namespace ratslam {

/// The best candidate of a search.
struct TemplateMatch {
  std::uint32_t id = 0;
  int shift = 0;       ///< [template columns]
  double error = 0.0;  ///< mean absolute difference at that shift
};

class TemplateMatcher {
 public:
  /// @throws std::invalid_argument as LocalViewParams::validate does.
  explicit TemplateMatcher(const LocalViewParams& params);

  /// Stores a template; its id is the number of templates before it.
  std::uint32_t add(const ViewTemplate& learned);

  /// The template of the smallest error, of equals the lowest id, then the lowest shift; none where the mean
  /// gate leaves no candidate.
  std::optional<TemplateMatch> findBest(const ViewTemplate& view);

  std::size_t size() const { return templates_.size(); }

 private:
  LocalViewParams params_;
  std::vector<ViewTemplate> templates_;
};

}  // namespace ratslam
