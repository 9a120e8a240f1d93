#include "ratslam_ros/support/decision_source.h"

namespace ratslam {

DecisionSource::DecisionSource(const std::string& parameter, std::function<bool()> state_is_published)
    : choice_(parameter == "state"    ? Choice::kState
              : parameter == "action" ? Choice::kAction
                                      : Choice::kUndecided),
      state_is_published_(std::move(state_is_published)) {}

bool DecisionSource::takesState() {
  if (choice_ == Choice::kUndecided) choice_ = Choice::kState;
  return choice_ == Choice::kState;
}

bool DecisionSource::takesAction() {
  if (choice_ == Choice::kUndecided) choice_ = state_is_published_() ? Choice::kState : Choice::kAction;
  return choice_ == Choice::kAction;
}

}  // namespace ratslam
