/// Image files of a folder: their order, and the times that belong to them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace ratslam {

/// Natural order of names: digits count as numbers, so that image9.png comes before image10.png.
bool naturallyBefore(const std::string& a, const std::string& b);

/// Paths of the .png, .jpg and .jpeg files of a folder (also with endings in capitals) in natural order of their
/// names. Names that begin with a dot are left out, because other systems leave such files.
/// @throws std::runtime_error naming the folder if it cannot be read
std::vector<std::string> imagesIn(const std::string& folder);

/// The same, but at least one image is required.
/// @throws std::runtime_error naming the folder if it is missing or has none
std::vector<std::string> listImages(const std::string& folder);

/// Which of `count` times in the file `times_path` belongs to each image.
///
/// If there are as many times as images, they belong together in order. If there are more times, the numbers in the
/// images' names decide. They count from 0, from 1 if the last number is that of the last time, or from the first
/// number if first and last fit.
/// @throws std::runtime_error if the numbers do not fit, or there are fewer times than images
std::vector<std::size_t> timesOf(const std::vector<std::string>& images, std::size_t count,
                                 const std::string& times_path);

}  // namespace ratslam
