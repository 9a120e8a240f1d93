#include "ratslam_ros/support/node_checkpoints.h"

#include <ros/console.h>

#include <cmath>
#include <filesystem>

namespace ratslam {
namespace {

constexpr const char* kEnd = "end";  // child of a part's state: the node ended there

}  // namespace

CheckpointSettings NodeCheckpoints::settings(const NodeParams& params, const std::string& part,
                                             const std::map<std::string, std::string>& parameters) {
  CheckpointSettings settings;
  if (!params.map_dir.empty()) settings.folder = std::filesystem::absolute(params.map_dir).string();
  settings.part = part;
  settings.period = params.autosave_period;
  settings.read_only = params.localise_only;
  settings.parameters = parameters;
  return settings;
}

NodeCheckpoints::NodeCheckpoints(const NodeParams& params, const std::string& part,
                                 const std::map<std::string, std::string>& parameters)
    : checkpoints_(settings(params, part, parameters)) {
  if (checkpoints_.enabled()) return;
  ROS_INFO("map_dir is not set: %s starts without memory, and what it learns ends with this node",
           part.c_str());
  if (std::abs(params.autosave_period - NodeParams().autosave_period) > 0.0) {
    ROS_WARN("autosave_period = %g has no effect: map_dir is not set, no checkpoints are kept",
             params.autosave_period);
  }
}

std::optional<State> NodeCheckpoints::resume() {
  std::optional<State> state =
      checkpoints_.resume([](const std::string& line) { ROS_WARN("%s", line.c_str()); });
  went_on_ = state && !state->hasChild(kEnd);
  return state;
}

void NodeCheckpoints::before(Stamp message, const Save& save) {
  checkpoints_.before(message, save);
  if (const auto why = checkpoints_.takeFailure()) lost_.report(*why);
}

void NodeCheckpoints::finish(const Save& save) {
  try {
    checkpoints_.saveNow([&save](State& state) {
      save(state);
      state.child(kEnd);
    });
  } catch (const std::exception& e) {
    ROS_ERROR("%s", e.what());
  }
}

}  // namespace ratslam
