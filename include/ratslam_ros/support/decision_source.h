/// Selects the topic of the pose cells that the map follows.
///
/// PoseCell/State has one message for every view event, so it also shows the progress of the pose cells. Recordings and
/// the pose cells of others have only PoseCell/TopologicalAction. A publisher of both topics advertises State before it
/// publishes any action. So the choice depends on whether State is advertised when the first action comes, and not on
/// which message comes first.
#pragma once

#include <functional>
#include <string>

namespace ratslam {

class DecisionSource {
 public:
  /// @param parameter  state, action or auto   @param state_is_published  asks the ROS master
  DecisionSource(const std::string& parameter, std::function<bool()> state_is_published);

  /// Whether the map uses a message of PoseCell/State, or of PoseCell/TopologicalAction.
  bool takesState();
  bool takesAction();
  /// Whether the actions were selected.
  bool followsActions() const { return choice_ == Choice::kAction; }

 private:
  enum class Choice { kUndecided, kState, kAction };
  Choice choice_;
  std::function<bool()> state_is_published_;
};

}  // namespace ratslam
