#include "ratslam/common/parameter_map.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <boost/property_tree/ini_parser.hpp>
#include <boost/property_tree/ptree.hpp>
#include <cstdlib>
#include <optional>
#include <sstream>

#include "ratslam/common/text_file.h"
#include "ratslam/common/yaml_check.h"

namespace ratslam {
namespace {

[[noreturn]] void throwWrongType(const std::string& key, const ParameterValue& value, const char* wanted) {
  const std::string given =
      value.is_list ? "[list of " + std::to_string(value.elements.size()) + "]" : shown(value.text);
  throw std::invalid_argument(key + ": value '" + given + "' is not " + wanted + " (from " + value.origin +
                              ")");
}

bool parseDouble(const std::string& text, double& number) {
  if (text.empty()) return false;
  char* end = nullptr;
  number = toNumber(text.c_str(), &end);
  return end == text.c_str() + text.size();
}

/// The elements of a list. Where only text can be given, as on a command line, it is written "[1.0, 2.0]".
/// @return none if it is no list
std::optional<std::vector<std::string>> elementsOf(const ParameterValue& value) {
  if (value.is_list) return value.elements;
  const std::string& text = value.text;
  if (text.size() < 2 || text.front() != '[' || text.back() != ']') return std::nullopt;
  const std::string inside = trimmed(text.substr(1, text.size() - 2));
  std::vector<std::string> elements;
  if (inside.empty()) return elements;
  for (std::size_t begin = 0; begin <= inside.size();) {
    const std::size_t end = std::min(inside.find(',', begin), inside.size());
    elements.push_back(trimmed(inside.substr(begin, end - begin)));
    begin = end + 1;
  }
  return elements;
}

/// The key for either of OpenRatSLAM's spellings.
std::string canonicalKey(const std::string& key) {
  return key == "vt_patch_normalisation" ? "vt_patch_normalise" : key;
}

/// Values that OpenRatSLAM's configurations imply.
const std::map<std::string, std::string> kReferenceArithmetic = {{"exp_solver", "relaxation"},
                                                                 {"pc_openratslam_injection", "true"}};

bool isOneOf(const std::string& text, const std::vector<std::string>& words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

/// Whether a file is OpenRatSLAM's ini: it begins with a [section] or key=value, and YAML with neither.
bool looksLikeIni(const std::string& path) {
  for (const TextLine& line : readLines(path)) {
    if (line.text.front() == '#' || line.text.front() == ';' || line.text == "---") continue;
    return line.text.front() == '[' || line.text.find('=') < line.text.find(':');
  }
  return false;
}

/// A value of an ini file without the comment after it.
std::string withoutComment(const std::string& value) {
  for (std::size_t i = 1; i < value.size(); ++i) {
    const bool blank_before = value[i - 1] == ' ' || value[i - 1] == '\t';
    if (blank_before && (value[i] == '#' || value[i] == ';')) return trimmed(value.substr(0, i));
  }
  return value;
}

std::string inLine(const std::string& path, int line_from_0) {
  return line_from_0 < 0 ? path : path + ":" + std::to_string(line_from_0 + 1);
}

/// Whether rosparam, by YAML 1.1, may read a value as an octal number, while others read a decimal one.
bool mayBeOctal(const YAML::Node& value) {
  const std::string& text = value.Scalar();
  const std::size_t zero = text.find_first_not_of("+-");
  return value.Tag() == "?" && zero <= 1 && text.size() > zero + 1 && text[zero] == '0' &&
         text.find_first_not_of("0123456789", zero) == std::string::npos;
}

/// A single value. @throws std::runtime_error if it is none
std::string scalarOf(const YAML::Node& value, const std::string& key, const std::string& origin) {
  if (!value.IsScalar())
    throw std::runtime_error(origin + ": " + shown(key) + ": its list holds more than single values");
  if (mayBeOctal(value)) {
    throw std::runtime_error(origin + ": " + shown(key) + ": value '" + shown(value.Scalar()) +
                             "' begins with 0, which makes it octal for rosparam; write it without");
  }
  return value.Scalar();
}

/// Hint to add to a message of the YAML library.
std::string hintFor(const std::string& reason) {
  return reason == "illegal map value"
             ? "; a line is 'key: value', with a blank behind the colon: this one or the one before is not"
             : "";
}

std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      diagonal = above;
    }
  }
  return row.back();
}

/// The name nearest to a key by edit distance, of equals the first; empty if it differs in more than a third of the
/// letters.
std::string nearestName(const std::string& key, const std::set<std::string>& names) {
  std::size_t least = std::max<std::size_t>(2, key.size() / 3) + 1;
  std::string nearest;
  for (const std::string& name : names) {
    // The distance is at least the difference in length. This test is cheap, and a key may be as long as a file.
    if (std::max(key.size(), name.size()) - std::min(key.size(), name.size()) >= least) continue;
    const std::size_t distance = editDistance(key, name);
    if (distance >= least) continue;
    least = distance;
    nearest = name;
  }
  return nearest;
}

}  // namespace

ParameterMap ParameterMap::fromYaml(const std::string& path) {
  const std::string text = readText(path);
  ParameterMap map;
  try {
    requireOneYamlDocument(text);
    const YAML::Node root = YAML::Load(text);
    if (root.IsNull()) return map;
    if (!root.IsMap()) throw std::runtime_error(path + ": a configuration is a list of 'key: value' lines");
    for (const auto& entry : root) {
      const auto key = entry.first.as<std::string>();
      ParameterValue value;
      value.origin = path + ":" + std::to_string(entry.first.Mark().line + 1);
      if (entry.second.IsScalar()) {
        value.text = scalarOf(entry.second, key, value.origin);
      } else if (entry.second.IsSequence()) {
        value.is_list = true;
        for (const auto& element : entry.second)
          value.elements.push_back(scalarOf(element, key, value.origin));
      } else {
        throw std::runtime_error(value.origin + ": " + shown(key) +
                                 (entry.second.IsMap()
                                      ? ": it holds keys of its own; all keys stand at the margin"
                                      : ": it has no value"));
      }
      if (map.has(canonicalKey(key)))
        throw std::runtime_error(value.origin + ": " + shown(key) + " is given twice");
      map.set(key, std::move(value));
    }
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(inLine(path, error.mark.line) + ": " + shown(error.msg) + hintFor(error.msg));
  }
  return map;
}

ParameterMap ParameterMap::fromIni(const std::string& path, std::vector<std::string>* remarks) {
  std::istringstream content(readText(path));
  boost::property_tree::ptree tree;
  try {
    boost::property_tree::read_ini(content, tree);
  } catch (const boost::property_tree::ini_parser_error& error) {
    throw std::runtime_error(path + ":" + std::to_string(error.line()) + ": " + shown(error.message()));
  }
  ParameterMap map;
  for (const auto& section : tree) {
    if (section.first == "draw") {
      if (remarks != nullptr) remarks->push_back(path + ": section [draw] is ignored");
      continue;
    }
    if (section.second.empty() && !section.second.data().empty()) {
      throw std::runtime_error(path + ": " + shown(section.first) +
                               " stands before any section; it belongs into " +
                               "[general], [ratslam] or [visual_odometry]");
    }
    if (section.first != "general" && section.first != "ratslam" && section.first != "visual_odometry") {
      throw std::runtime_error(path + ": section [" + shown(section.first) +
                               "] is none of [general], [ratslam], [visual_odometry], [draw]");
    }
    for (const auto& entry : section.second) {
      ParameterValue value;
      value.text = withoutComment(entry.second.data());
      value.origin = path + " [" + section.first + "]";
      if (map.has(canonicalKey(entry.first))) {
        throw std::runtime_error(value.origin + ": " + shown(entry.first) + " is given twice");
      }
      map.set(entry.first, std::move(value));
    }
  }
  for (const auto& [key, text] : kReferenceArithmetic) {
    if (map.has(key)) continue;
    ParameterValue value;
    value.text = text;
    value.origin = path + ", an OpenRatSLAM configuration";
    map.set(key, std::move(value));
    if (remarks != nullptr) {
      remarks->push_back(path + ": an OpenRatSLAM configuration implies OpenRatSLAM's arithmetic, " + key +
                         "=" + text + ", unless " + key + " is set");
    }
  }
  return map;
}

ParameterMap ParameterMap::fromFile(const std::string& path, std::vector<std::string>* remarks) {
  return looksLikeIni(path) ? fromIni(path, remarks) : fromYaml(path);
}

void ParameterMap::set(const std::string& key, ParameterValue value) {
  values_[canonicalKey(key)] = std::move(value);
}

void ParameterMap::setFromAssignment(const std::string& assignment, const std::string& origin) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw std::invalid_argument("'" + shown(assignment) + "' is not of the form key=value");
  }
  ParameterValue value;
  value.text = trimmed(assignment.substr(equals + 1));
  value.origin = origin;
  set(trimmed(assignment.substr(0, equals)), std::move(value));
}

void ParameterMap::rejectUnknown(const std::set<std::string>& known) const {
  for (const auto& [key, value] : values_) {
    if (known.count(key) != 0) continue;
    std::string message = shown(key) + ": no parameter has this name (from " + value.origin + ")";
    const std::string nearest = nearestName(key, known);
    if (!nearest.empty()) message += "; did you mean " + nearest + "?";
    throw std::invalid_argument(message);
  }
}

void ParameterMap::convert(const std::string& key, const ParameterValue& value, bool& field) {
  // The booleans of YAML 1.1, and so of rosparam.
  if (isOneOf(value.text, {"true", "True", "TRUE", "yes", "Yes", "YES", "on", "On", "ON", "1"})) {
    field = true;
  } else if (isOneOf(value.text, {"false", "False", "FALSE", "no", "No", "NO", "off", "Off", "OFF", "0"})) {
    field = false;
  } else {
    throwWrongType(key, value, "true or false");
  }
}

void ParameterMap::convert(const std::string& key, const ParameterValue& value, int& field) {
  double number = 0.0;
  if (value.is_list || !parseDouble(value.text, number) || number != std::floor(number) ||
      std::abs(number) > 2147483647.0) {
    throwWrongType(key, value, "a whole number of at most 2147483647");
  }
  field = static_cast<int>(number);
}

void ParameterMap::convert(const std::string& key, const ParameterValue& value, double& field) {
  double number = 0.0;
  if (value.is_list || !parseDouble(value.text, number)) throwWrongType(key, value, "a number");
  field = number;
}

void ParameterMap::convert(const std::string& key, const ParameterValue& value, std::string& field) {
  if (value.is_list) throwWrongType(key, value, "a single word or text");
  field = value.text;
}

void ParameterMap::convert(const std::string& key, const ParameterValue& value, std::vector<double>& field) {
  const char* const wanted = "a list of numbers such as [1.0, 2.0]";
  const std::optional<std::vector<std::string>> elements = elementsOf(value);
  if (!elements) throwWrongType(key, value, wanted);
  std::vector<double> numbers;
  for (const std::string& element : *elements) {
    double number = 0.0;
    if (!parseDouble(element, number)) throwWrongType(key, value, wanted);
    numbers.push_back(number);
  }
  field = std::move(numbers);
}

}  // namespace ratslam
