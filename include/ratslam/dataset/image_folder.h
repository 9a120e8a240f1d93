/// A folder of image files: their order, and which time of a list belongs to which of them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace ratslam {

/// Whether `a` comes before `b` where runs of digits count as numbers: image9.png before image10.png.
bool naturallyBefore(const std::string& a, const std::string& b);

/// Paths of the .png, .jpg and .jpeg files of a folder (endings in capitals as well) in natural order of their
/// names; those that begin with a dot, as foreign systems leave them, are left out.
/// @throws std::runtime_error naming the folder where it cannot be read
std::vector<std::string> imagesIn(const std::string& folder);

/// The same, of which there must be some.
/// @throws std::runtime_error naming the folder where it is missing or has none
std::vector<std::string> listImages(const std::string& folder);

/// Which of `count` times in the file `times_path` belongs to each image.
///
/// As many times as images: one after the other. More times: the numbers in the images' names tell, counted
/// from 0, from 1 where the last number is that of the last time, or from the first where first and last fit.
/// @throws std::runtime_error where they do not tell, or there are fewer times than images
std::vector<std::size_t> timesOf(const std::vector<std::string>& images, std::size_t count,
                                 const std::string& times_path);

}  // namespace ratslam
