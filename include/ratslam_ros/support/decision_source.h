/// Which of the two topics of the pose cells the map follows.
///
/// PoseCell/State has one message for every view event and therefore also says how far the pose cells have
/// got. Recordings and pose cells of others have only PoseCell/TopologicalAction. A publisher of both
/// advertises State before it publishes any action, so whether somebody advertises State when the first
/// action comes decides it independently of which message arrives first.
#pragma once

#include <functional>
#include <string>

namespace ratslam {

class DecisionSource {
 public:
  /// @param parameter  state, action or auto   @param state_is_published  asks the ROS master
  DecisionSource(const std::string& parameter, std::function<bool()> state_is_published);

  /// Whether a message of that topic counts.
  bool takesState();
  bool takesAction();

 private:
  enum class Choice { kUndecided, kState, kAction };
  Choice choice_;
  std::function<bool()> state_is_published_;
};

}  // namespace ratslam
