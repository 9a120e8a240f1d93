/// Checkpoints of a node in ~map_dir (part_checkpoints.h), with log messages.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "ratslam/system/part_checkpoints.h"
#include "ratslam_ros/support/counted_warning.h"
#include "ratslam_ros/support/node_parameters.h"

namespace ratslam {

/// Parameters of a part that consists of several structs.
template <class... Params>
std::map<std::string, std::string> partParameters(const ParameterMap& parameters) {
  std::map<std::string, std::string> all;
  (all.merge(parameterTexts(readParams<Params>(parameters))), ...);
  return all;
}

class NodeCheckpoints {
 public:
  using Save = PartCheckpoints::Save;

  /// @param parameters  of the part, from parameterTexts: a checkpoint with others is refused
  /// @throws std::runtime_error if the folder cannot be used
  NodeCheckpoints(const NodeParams& params, const std::string& part,
                  const std::map<std::string, std::string>& parameters);

  /// State of the part at its last usable checkpoint. Logs which one, or that there is none. None without map_dir.
  /// @throws std::runtime_error if it was made with other parameters
  std::optional<State> resume();
  /// Whether the process went on after the checkpoint that was resumed. Then it has published what waits in it.
  bool wentOn() const { return went_on_; }

  /// To be called before a message is processed.
  void before(Stamp message, const Save& save);
  /// To be called when the node ends.
  void finish(const Save& save);

  PartCheckpoints& files() { return checkpoints_; }

 private:
  static CheckpointSettings settings(const NodeParams& params, const std::string& part,
                                     const std::map<std::string, std::string>& parameters);

  PartCheckpoints checkpoints_;
  bool went_on_ = false;
  CountedWarning lost_;
};

}  // namespace ratslam
