/// Parameter values by key, wherever they come from: a YAML file, an OpenRatSLAM ini file, `--set key=value`
/// or the ROS parameter server (which fills a map of this type).
///
/// Values are kept as text together with where they came from; `read` gives them their types and says in one
/// line what is wrong with a value: key, value, what would be right, and the place it came from.
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
  /// OpenRatSLAM's ini: [general] topic_root, [ratslam], [visual_odometry]; [draw] is left out. It means
  /// OpenRatSLAM's map: what it does not say comes from its arithmetic, not from our own.
  /// @param remarks  gets a line for everything that is left out or implied
  /// @throws std::runtime_error naming file, line and reason
  static ParameterMap fromIni(const std::string& path, std::vector<std::string>* remarks = nullptr);
  /// By its first line, whatever its name: a [section] or key=value begins OpenRatSLAM's ini, all else is YAML.
  static ParameterMap fromFile(const std::string& path, std::vector<std::string>* remarks = nullptr);

  /// OpenRatSLAM's second spelling vt_patch_normalisation is stored under the first.
  void set(const std::string& key, ParameterValue value);
  /// "key=value". @throws std::invalid_argument where it is not of that form
  void setFromAssignment(const std::string& assignment);

  bool has(const std::string& key) const { return values_.count(key) != 0; }
  const std::map<std::string, ParameterValue>& values() const { return values_; }

  /// Fills the fields that are present and leaves the others at their defaults, then validates.
  /// @throws std::invalid_argument naming key, value, what would be right and the origin
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
