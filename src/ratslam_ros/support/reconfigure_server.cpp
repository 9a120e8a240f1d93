#include "ratslam_ros/support/reconfigure_server.h"

#include <dynamic_reconfigure/ConfigDescription.h>
#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "ratslam/common/text_file.h"

namespace ratslam {

std::string numberText(double number, bool whole) {
  char text[32];
  std::snprintf(text, sizeof(text), whole ? "%.0f" : "%.17g", number);
  return text;
}

ReconfigureServer::ReconfigureServer(const ros::NodeHandle& own, std::vector<ReconfigurableField> fields,
                                     Apply apply)
    : own_(own), fields_(std::move(fields)), apply_(std::move(apply)) {
  const bool latched = true;
  description_ = own_.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, latched);
  updates_ = own_.advertise<dynamic_reconfigure::Config>("parameter_updates", 1, latched);
  service_ = own_.advertiseService("set_parameters", &ReconfigureServer::onRequest, this);
  publishDescription();
  updates_.publish(config([](const ReconfigurableField& field) { return field.value; }));
}

void ReconfigureServer::publishDescription() {
  dynamic_reconfigure::Group group;
  group.name = "Default";
  for (const ReconfigurableField& field : fields_) {
    dynamic_reconfigure::ParamDescription parameter;
    parameter.name = field.name;
    parameter.type = field.whole ? "int" : "double";
    parameter.description = field.meaning;
    group.parameters.push_back(parameter);
  }
  dynamic_reconfigure::ConfigDescription description;
  description.groups.push_back(group);
  description.max = config([](const ReconfigurableField& field) { return field.bounds.max; });
  description.min = config([](const ReconfigurableField& field) { return field.bounds.min; });
  description.dflt = config([](const ReconfigurableField& field) { return field.value; });
  description_.publish(description);
}

dynamic_reconfigure::Config ReconfigureServer::config(Property property) const {
  dynamic_reconfigure::Config config;
  for (const ReconfigurableField& field : fields_) {
    if (field.whole) {
      dynamic_reconfigure::IntParameter parameter;
      parameter.name = field.name;
      parameter.value = static_cast<std::int32_t>(property(field));
      config.ints.push_back(parameter);
    } else {
      dynamic_reconfigure::DoubleParameter parameter;
      parameter.name = field.name;
      parameter.value = property(field);
      config.doubles.push_back(parameter);
    }
  }
  dynamic_reconfigure::GroupState state;
  state.name = "Default";
  state.state = 1;
  config.groups.push_back(state);
  return config;
}

bool ReconfigureServer::onRequest(dynamic_reconfigure::ReconfigureRequest& request,
                                  dynamic_reconfigure::ReconfigureResponse& response) {
  std::vector<ReconfigurableField> wanted = fields_;
  std::map<std::string, std::string> changed;
  const auto set = [&](const std::string& name, double value) {
    const auto field = std::find_if(wanted.begin(), wanted.end(),
                                    [&name](const ReconfigurableField& known) { return known.name == name; });
    if (field == wanted.end())
      throw std::invalid_argument(name + ": it cannot be changed while the node runs");
    if (field->whole && value != std::floor(value))
      throw std::invalid_argument(name + ": value " + numberText(value, false) +
                                  " is not allowed: a whole number");
    if (field->value == value) return;
    field->value = value;
    changed[name] = numberText(value, field->whole);
  };
  try {
    for (const auto& parameter : request.config.doubles) set(parameter.name, parameter.value);
    for (const auto& parameter : request.config.ints) set(parameter.name, parameter.value);
    for (const auto& parameter : request.config.bools) set(parameter.name, parameter.value);
    for (const auto& parameter : request.config.strs) {
      throw std::invalid_argument(parameter.name + ": value '" + shown(parameter.value) +
                                  "' is not allowed: what can be changed while the node runs are numbers");
    }
    if (!changed.empty()) apply_(changed);
  } catch (const std::exception& e) {
    ROS_ERROR("%s: refused: %s", service_.getService().c_str(), e.what());
    return false;
  }
  fields_ = wanted;
  response.config = config([](const ReconfigurableField& field) { return field.value; });
  updates_.publish(response.config);
  return true;
}

}  // namespace ratslam
