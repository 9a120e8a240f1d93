/// Changes of a stage's thresholds and gains while its node runs (dynamic_reconfigure). Each change is published on
/// ParameterChange with the stamp after which it holds, so that `ratslam_run --changes` can repeat the run.
#pragma once

#include "ratslam/system/parameter_changes.h"
#include "ratslam_ros/ParameterChange.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/node_parameters.h"
#include "ratslam_ros/support/reconfigure_server.h"

namespace ratslam {

/// Fields of a parameter struct that may change.
template <class Params>
std::vector<ReconfigurableField> reconfigurableFields(Params params) {
  std::vector<ReconfigurableField> fields;
  const std::set<std::string> keys = changeableKeys(params);
  params.visitFields([&](const std::string& key, const auto& value, const Bounds& bounds,
                         [[maybe_unused]] const char* meaning) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_arithmetic_v<Value>) {
      if (keys.count(key) == 0) return;
      fields.push_back({key, std::is_integral_v<Value>, static_cast<double>(value), bounds, meaning});
    }
  });
  return fields;
}

template <class Stage, class Params>
class StageTuning {
 public:
  /// @param own  handle of the node's private names   @param stage  outlives this
  StageTuning(ros::NodeHandle handle, const ros::NodeHandle& own, const ParameterMap& parameters,
              Stage& stage)
      : node_(own.getNamespace()),
        parameters_(parameters),
        stage_(stage),
        changes_(handle.advertise<ratslam_ros::ParameterChange>(
            topicName(readParams<NodeParams>(parameters).topic_root, "ParameterChange"), 100)),
        server_(own, reconfigurableFields(readParams<Params>(parameters)),
                [this](const std::map<std::string, std::string>& changed) { apply(changed); }) {}

 private:
  void apply(const std::map<std::string, std::string>& changed) {
    ParameterMap parameters = parameters_;
    for (const auto& [name, value] : changed) parameters.setFromAssignment(name + "=" + value);
    const Stamp after = stage_.latestProcessed();
    stage_.change(after, readParams<Params>(parameters));
    parameters_ = parameters;
    for (const auto& [name, value] : changed) {
      ratslam_ros::ParameterChange message;
      message.header.stamp = stampToRos(after);
      message.node = node_;
      message.name = name;
      message.value = value;
      changes_.publish(message);
      ROS_INFO("%s is %s from here on (after %u.%09u)", name.c_str(), value.c_str(), message.header.stamp.sec,
               message.header.stamp.nsec);
    }
  }

  std::string node_;
  ParameterMap parameters_;
  Stage& stage_;
  ros::Publisher changes_;
  ReconfigureServer server_;
};

}  // namespace ratslam
