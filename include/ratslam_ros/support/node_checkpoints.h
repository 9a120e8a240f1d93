/// Checkpoints of a node in ~map_dir (part_checkpoints.h), with what there is to say in the log.
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

  /// @param parameters  of the part, as parameterTexts gives them: a checkpoint of others is refused
  /// @throws std::runtime_error where the folder cannot be used
  NodeCheckpoints(const NodeParams& params, const std::string& part,
                  const std::map<std::string, std::string>& parameters);

  /// What the part knew at its last good checkpoint; says which, or that there is none. None without map_dir.
  /// @throws std::runtime_error where it was made with other parameters
  std::optional<State> resume();

  /// To be called before a message is taken in.
  void before(Stamp message, const Save& save);
  /// To be called when the node ends.
  void finish(const Save& save);

  PartCheckpoints& files() { return checkpoints_; }

 private:
  static CheckpointSettings settings(const NodeParams& params, const std::string& part,
                                     const std::map<std::string, std::string>& parameters);

  PartCheckpoints checkpoints_;
  CountedWarning lost_;
};

}  // namespace ratslam
