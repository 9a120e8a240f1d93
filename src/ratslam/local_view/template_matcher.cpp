#include "ratslam/local_view/template_matcher.h"

#include <cmath>

namespace ratslam {

TemplateMatcher::TemplateMatcher(const LocalViewParams& params) : params_(params) { params_.validate(); }

std::uint32_t TemplateMatcher::add(const ViewTemplate& learned) {
  templates_.push_back(learned);
  return static_cast<std::uint32_t>(templates_.size() - 1);
}

std::optional<TemplateMatch> TemplateMatcher::findBest(const ViewTemplate& view) {
  std::optional<TemplateMatch> best;
  const int columns = params_.view_template.x_size;
  const int rows = params_.view_template.y_size;
  const int compared = params_.comparedColumns();
  const int first = params_.panoramic ? 0 : params_.shift_match;
  for (std::uint32_t id = 0; id < templates_.size(); ++id) {
    if (std::abs(view.mean - templates_[id].mean) > params_.meanGate()) continue;
    for (int i = 0; i < params_.shiftCount(); ++i) {
      const int shift = i * params_.step_match;
      double sum = 0.0;
      for (int y = 0; y < rows; ++y) {
        const double* view_row = view.values.data() + y * columns + first;
        const double* learned_row = templates_[id].values.data() + y * columns;
        for (int x = 0; x < compared; ++x) sum += std::abs(view_row[x] - learned_row[(x + shift) % columns]);
      }
      const double error = sum / (compared * rows);
      if (!best || error < best->error) best = TemplateMatch{id, shift, error};
    }
  }
  return best;
}

}  // namespace ratslam
