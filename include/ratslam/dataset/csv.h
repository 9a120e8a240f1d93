/// Numbers in lines of text, for the readers of data sets.
#pragma once

#include <string>
#include <vector>

namespace ratslam {

/// The words between the commas of a line, without blanks at their ends.
std::vector<std::string> splitCsv(const std::string& line);

/// @return false if the text is not one finite decimal number
bool parseNumber(const std::string& text, double& number);

}  // namespace ratslam
