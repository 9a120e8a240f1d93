/// Changes of parameters while the nodes ran, for FILE_changes.csv beside the trajectories.
#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "ratslam/common/state.h"
#include "ratslam/system/parameter_changes.h"
#include "ratslam_ros/support/message_guard.h"

namespace ratslam {

class ChangeLog {
 public:
  ChangeLog(ros::NodeHandle handle, const std::string& topic);

  /// Adds the changes to the state of the map, so that those of a trajectory stay together when the node restarts.
  void save(State& state) const { state.set(kName, rows()); }
  /// Takes those of a loaded state; none if it holds none.
  void load(const State& state);

  /// Writes the changes in order of time; no file if there are none. @param file  as for writeTrajectories
  /// @throws std::runtime_error naming the file that cannot be written
  void write(const std::string& file) const;

 private:
  /// Lines after_ns,name,value in order of time.
  std::string rows() const;

  static constexpr const char* kName = "parameter_changes";

  std::vector<ParameterChange> changes_;
  MessageGuard guard_;
  ros::Subscriber subscriber_;
};

}  // namespace ratslam
