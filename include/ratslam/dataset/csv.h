/// Numbers in lines of text: what the readers of data sets share.
#pragma once

#include <string>
#include <vector>

namespace ratslam {

/// The words between the commas of a line, without blanks at their ends.
std::vector<std::string> splitCsv(const std::string& line);

/// @return false where the text is not one finite number, written in the decimal system
bool parseNumber(const std::string& text, double& number);

}  // namespace ratslam
