/// Parameter values by key from a YAML file, an OpenRatSLAM ini file, `--set key=value` or the ROS parameter server
/// (which fills a map of this type).
///
/// Values are kept as text with their origin. `read` converts them to their types. For a bad value it reports in
/// one line the key, the value, the requirement and the origin.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "ratslam/common/params.h"

namespace ratslam {

struct ParameterValue {
  std::string text;                   ///< a scalar
  std::vector<std::string> elements;  ///< a list (text is empty then)
  bool is_list = false;
  std::string origin;  ///< "config/kitti.yaml:12", "--set", "/ratslam_lv/vt_shift_match"
};

class ParameterMap {
 public:
  /// Flat `key: value` YAML. @throws std::runtime_error naming file, line and reason
  static ParameterMap fromYaml(const std::string& path);
  /// Reads OpenRatSLAM's ini: [general] topic_root, [ratslam], [visual_odometry]; [draw] is ignored. Such a file
  /// implies OpenRatSLAM's arithmetic: its solver and its injection are the defaults then.
  /// @param remarks  receives a line for everything that is ignored or implied
  /// @throws std::runtime_error naming file, line and reason
  static ParameterMap fromIni(const std::string& path, std::vector<std::string>* remarks = nullptr);
  /// Reads either form. The first line decides: a [section] or key=value begins an ini file, anything else is YAML.
  static ParameterMap fromFile(const std::string& path, std::vector<std::string>* remarks = nullptr);

  /// Sets a value. OpenRatSLAM's spelling vt_patch_normalisation is stored as vt_patch_normalise.
  void set(const std::string& key, ParameterValue value);
  /// Sets a value by "key=value". @param origin  of the text. @throws std::invalid_argument if it has another form
  void setFromAssignment(const std::string& assignment, const std::string& origin = "the command line");

  bool has(const std::string& key) const { return values_.count(key) != 0; }
  const std::map<std::string, ParameterValue>& values() const { return values_; }

  /// Sets the fields whose keys are present, leaves the others at their defaults, and validates.
  /// @throws std::invalid_argument naming key, value, requirement and origin
  template <class Params>
  void read(Params& params) const {
    params.visitFields([this](const std::string& key, auto& field, const Bounds&, const char*) {
      const auto found = values_.find(key);
      if (found != values_.end()) convert(key, found->second, field);
    });
    params.validate();
  }

  /// @throws std::invalid_argument for the first key that is not in `known`, with the nearest known key
  void rejectUnknown(const std::set<std::string>& known) const;

 private:
  static void convert(const std::string& key, const ParameterValue& value, bool& field);
  static void convert(const std::string& key, const ParameterValue& value, int& field);
  static void convert(const std::string& key, const ParameterValue& value, double& field);
  static void convert(const std::string& key, const ParameterValue& value, std::string& field);
  static void convert(const std::string& key, const ParameterValue& value, std::vector<double>& field);

  std::map<std::string, ParameterValue> values_;
};

/// Keys of a parameter struct.
template <class Params>
std::set<std::string> keysOf() {
  std::set<std::string> keys;
  Params params;
  params.visitFields(
      [&keys](const std::string& key, auto&, const Bounds&, const char*) { keys.insert(key); });
  return keys;
}

}  // namespace ratslam
