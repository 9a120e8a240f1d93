/// Helpers for both writing and reading the tables of a map file.
#pragma once

#include <cstring>
#include <string>

#include "ratslam/common/state.h"

namespace ratslam {

/// A name quoted for SQL.
inline std::string quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

/// Whether the entries of a column are SQL numbers; all others are blobs.
inline bool isNumberColumn(const StateArray& array) { return array.shape.size() == 1 && array.ends.empty(); }

template <class T>
T numberAt(const std::uint8_t* bytes) {
  T value{};
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

}  // namespace ratslam
