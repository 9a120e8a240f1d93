/// Check of YAML before it is loaded, because some texts make the library recurse or loop without end.
#pragma once

#include <string>

namespace ratslam {

/// @throws YAML::Exception with the line, if the text holds several documents, is nested too deeply, or is no YAML
void requireOneYamlDocument(const std::string& text);

}  // namespace ratslam
