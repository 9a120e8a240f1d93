/// YAML of others, looked at before it is loaded: no text may make the library recurse or go on without end.
#pragma once

#include <string>

namespace ratslam {

/// @throws YAML::Exception with the line where a text holds several documents, is nested deeper than anything of ours,
/// or is no YAML
void requireOneYamlDocument(const std::string& text);

}  // namespace ratslam
