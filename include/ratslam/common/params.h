/// Parameter structs: each parameter is described once.
///
/// A parameter struct lists its fields in one template method. The ROS parameter server, YAML and ini files,
/// `--set key=value`, range checks and the tables of the documents all visit it:
///
///     struct PoseCellParams {
///       int n_xy = 21;
///       template <class Visitor>
///       void visitFields(Visitor&& visit) {
///         visit("pc_dim_xy", n_xy, Bounds{1, 4096}, "cells along x and y");
///       }
///       void validate() const;   // bounds of all fields (checkBounds), then relations between fields
///     };
///
/// Field types: bool, int, double, std::string, std::vector<double>. Only the struct holds the defaults.
#pragma once

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace ratslam {

/// Closed interval of allowed values of a number.
struct Bounds {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// @throws std::invalid_argument "key: value V is not allowed: REQUIREMENT".
template <class T>
[[noreturn]] void throwBadValue(const std::string& key, const T& value, const std::string& requirement) {
  std::ostringstream message;
  message.precision(std::numeric_limits<double>::max_digits10);
  message << key << ": value " << value << " is not allowed: " << requirement;
  throw std::invalid_argument(message.str());
}

/// Checks every number of a parameter struct against its bounds.
/// @throws std::invalid_argument naming key, value and bound; NaN is never within bounds.
template <class Params>
void checkBounds(const Params& params) {
  Params copy = params;  // visitFields also serves for writing, so it is not const
  copy.visitFields([](const std::string& key, const auto& value, const Bounds& bounds, const char*) {
    if constexpr (std::is_arithmetic_v<std::decay_t<decltype(value)>>) {
      const double number = static_cast<double>(value);
      if (!(number >= bounds.min && number <= bounds.max)) {
        std::ostringstream requirement;
        requirement << "it must lie within [" << bounds.min << ", " << bounds.max << "]";
        throwBadValue(key, value, requirement.str());
      }
    }
  });
}

}  // namespace ratslam
