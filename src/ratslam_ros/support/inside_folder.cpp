#include "ratslam_ros/support/inside_folder.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <stdexcept>

#include "ratslam/common/text_file.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestName = 200;  ///< of a file system 255; endings are added to it

/// Finds the folder that contains `path` by name. @return the rest of the path; empty if no folder does
fs::path restWithin(const fs::path& path, const std::vector<std::string>& folders, fs::path& folder) {
  for (const std::string& allowed : folders) {
    if (allowed.empty()) continue;
    folder = fs::absolute(allowed).lexically_normal();
    if (!folder.has_filename()) folder = folder.parent_path();
    if (path.is_relative()) return path;
    fs::path rest = path.lexically_relative(folder);
    if (!rest.empty() && *rest.begin() != ".." && rest != ".") return rest;
  }
  return {};
}

}  // namespace

std::string pathInside(const std::string& path, const std::vector<std::string>& folders,
                       const std::string& ending) {
  std::string allowed;
  for (const std::string& folder : folders) {
    if (!folder.empty()) allowed += (allowed.empty() ? "" : " or ") + folder;
  }
  const auto refuse = [&path](const std::string& why) {
    throw std::runtime_error("path '" + path + "': " + why);
  };
  if (allowed.empty()) refuse("no folder is allowed: the parameter map_dir is not set");
  if (path.empty()) refuse("it must name a file inside " + allowed);
  if (std::any_of(path.begin(), path.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }))
    throw std::runtime_error("path '" + shown(path) + "': it must not hold control characters");
  for (const fs::path& part : fs::path(path)) {
    if (part == "..") refuse("it must not lead upwards (..)");
    if (part.string().size() > kLongestName) {
      throw std::runtime_error("path '" + shown(path) + "': a name must not be longer than " +
                               std::to_string(kLongestName) + " bytes");
    }
  }
  fs::path folder;
  const fs::path rest = restWithin(path, folders, folder);
  if (rest.empty() || !rest.has_filename()) refuse("it must name a file inside " + allowed);
  fs::path whole = folder;
  for (const fs::path& part : rest) {
    whole /= part;
    if (fs::is_symlink(fs::symlink_status(whole))) refuse(whole.string() + " is a symbolic link");
  }
  if (!fs::is_directory(whole.parent_path())) refuse("there is no folder " + whole.parent_path().string());
  if (fs::is_directory(whole)) refuse("it is a folder");
  if (!ending.empty() && whole.extension() != ending) refuse("its name must end in " + ending);
  return whole.string();
}

}  // namespace ratslam
