/// Text files of numbers, and folders of images: what the readers of data sets share.
#pragma once

#include <string>
#include <vector>

namespace ratslam {

/// The words between the commas of a line, without blanks at their ends.
std::vector<std::string> splitCsv(const std::string& line);

/// @return false where the text is not one finite number
bool parseNumber(const std::string& text, double& number);

/// Paths of the .png, .jpg and .jpeg files of a folder, by name.
/// @throws std::runtime_error naming the folder where it is missing or has none
std::vector<std::string> listImages(const std::string& folder);

}  // namespace ratslam
