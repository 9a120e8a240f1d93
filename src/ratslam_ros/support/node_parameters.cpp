#include "ratslam_ros/support/node_parameters.h"

#include <ros/console.h>
#include <ros/names.h>
#include <ros/param.h>

#include <cstdio>
#include <stdexcept>
#include <utility>
#include <vector>

#include "ratslam/common/paths.h"
#include "ratslam/common/text_file.h"

namespace ratslam {
namespace {

std::string scalarText(XmlRpc::XmlRpcValue& value, const std::string& origin) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value) ? "true" : "false";
    case XmlRpc::XmlRpcValue::TypeInt:
      return std::to_string(static_cast<int>(value));
    case XmlRpc::XmlRpcValue::TypeDouble: {
      char text[32];
      std::snprintf(text, sizeof(text), "%.17g", static_cast<double>(value));
      return text;
    }
    case XmlRpc::XmlRpcValue::TypeString:
      return static_cast<std::string>(value);
    default:
      throw std::invalid_argument(origin + ": a number, text, boolean or a list of these is expected");
  }
}

/// A scalar as a person writes it: the server keeps 0.04 as 0.040000000000000001.
std::string written(const std::string& scalar) {
  char* end = nullptr;
  const double number = toNumber(scalar.c_str(), &end);
  if (scalar.empty() || *end != '\0') return shown(scalar);
  char text[32];
  std::snprintf(text, sizeof(text), "%.10g", number);
  return text;
}

std::string written(const ParameterValue& value) {
  if (!value.is_list) return written(value.text);
  std::string list = "[";
  for (const std::string& element : value.elements) list += (list == "[" ? "" : ", ") + written(element);
  return list + "]";
}

/// Says where a node's private parameter differs from its file: the server also keeps what an earlier launch has set.
void sayWhatOverrides(const ParameterMap& file, const ParameterMap& overriding) {
  for (const auto& [key, value] : overriding.values()) {
    if (!file.has(key)) continue;
    const ParameterValue& replaced = file.values().at(key);
    const std::string now = written(value);
    const std::string before = written(replaced);
    if (now == before) continue;
    ROS_INFO("%s: %s counts, not %s of %s; if another launch has left it, rosparam delete %s", key.c_str(),
             now.c_str(), before.c_str(), replaced.origin.c_str(), value.origin.c_str());
  }
}

}  // namespace

ParameterMap parametersFromXmlRpc(XmlRpc::XmlRpcValue& dictionary, const std::string& ns) {
  ParameterMap map;
  for (auto& [key, value] : dictionary) {
    ParameterValue parameter;
    parameter.origin = ros::names::append(ns, key);
    parameter.is_list = value.getType() == XmlRpc::XmlRpcValue::TypeArray;
    if (parameter.is_list) {
      for (int i = 0; i < value.size(); ++i)
        parameter.elements.push_back(scalarText(value[i], parameter.origin));
    } else {
      parameter.text = scalarText(value, parameter.origin);
    }
    map.set(key, parameter);
  }
  return map;
}

ParameterMap loadNodeParameters(int argc, const char* const* argv, const ros::NodeHandle& private_handle) {
  if (argc > 2) throw std::invalid_argument("at most one argument, a configuration file, is expected");
  ParameterMap map;
  if (argc == 2) {
    std::vector<std::string> remarks;
    map = ParameterMap::fromFile(argv[1], &remarks);
    for (const std::string& remark : remarks) ROS_INFO("%s", remark.c_str());
  }
  const std::string& ns = private_handle.getNamespace();
  XmlRpc::XmlRpcValue dictionary;
  if (ros::param::get(ns, dictionary) && dictionary.getType() == XmlRpc::XmlRpcValue::TypeStruct) {
    const ParameterMap overriding = parametersFromXmlRpc(dictionary, ns);
    sayWhatOverrides(map, overriding);
    for (const auto& [key, value] : overriding.values()) map.set(key, value);
  }
  map.rejectUnknown(systemKeys());
  for (const char* const path : {"map_dir", "trajectory_file"}) {
    if (!map.has(path)) continue;
    ParameterValue value = map.values().at(path);
    value.text = withHome(value.text);
    map.set(path, std::move(value));
  }
  const NodeParams nodes = readParams<NodeParams>(map);
  if (nodes.localise_only && nodes.map_dir.empty()) {
    throwBadValue("localise_only", "true", "it needs a map: set map_dir");
  }
  return map;
}

std::string topicName(const std::string& topic_root, const std::string& name) {
  if (topic_root.empty()) return name;
  std::string topic = ros::names::clean(topic_root + "/" + name);
  std::string error;
  if (!ros::names::validate(topic, error)) throwBadValue("topic_root", "'" + topic_root + "'", error);
  return topic;
}

}  // namespace ratslam
