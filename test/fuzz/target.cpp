#include "target.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

namespace ratslam::fuzz {

Target findTarget(const std::string& name) {
  std::vector<Target> all = fileTargets();
  for (const auto& more : {stageTargets(), messageTargets(), std::vector<Target>{plantedFault()}}) {
    all.insert(all.end(), more.begin(), more.end());
  }
  std::string names;
  for (const Target& target : all) {
    if (name == target.name) return target;
    names += std::string(names.empty() ? "" : " ") + target.name;
  }
  throw std::runtime_error("no fuzz target '" + name + "'; there are: " + names);
}

void mayRefuse(const std::function<void()>& action) {
  constexpr std::size_t kLongest = 1000;
  std::string said;
  try {
    action();
    return;
  } catch (const std::invalid_argument& error) {
    said = error.what();
  } catch (const std::runtime_error& error) {
    said = error.what();
  }
  // The standard library's own words (stod, stoll) say nothing to a user.
  const std::string last = said.substr(said.rfind(' ') + 1);
  const std::set<std::string> library{"stoi", "stol", "stoll", "stoul", "stoull", "stof", "stod", "stold"};
  const bool of_library = library.count(last) != 0;
  const bool printable = std::none_of(said.begin(), said.end(),
                                      [](char letter) { return static_cast<unsigned char>(letter) < 0x20; });
  const bool clear = said.size() > 8 && said.size() < kLongest && printable && !of_library;
  if (!clear) std::fprintf(stderr, "refused with: '%s'\n", said.c_str());
  require(clear, "a refusal is one line that says what is wrong");
}

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "fuzz target: not so: %s\n", what);
  std::abort();
}

Folder::Folder() {
  namespace fs = std::filesystem;
  const fs::path memory = fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
  path_ = (memory / ("ratslam_fuzz_" + std::to_string(getpid()))).string();
  fs::remove_all(path_);
  fs::create_directories(path_);
}

Folder::~Folder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string Folder::write(const std::string& name, const std::uint8_t* data, std::size_t size) const {
  const std::filesystem::path path = std::filesystem::path(path_) / name;
  std::filesystem::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return path.string();
}

std::string Folder::write(const std::string& name, const Bytes& content) const {
  return write(name, content.data(), content.size());
}

Bytes Reader::takeBytes(std::size_t count) {
  count = std::min(count, input_.size() - next_);
  const auto begin = input_.begin() + static_cast<std::ptrdiff_t>(next_);
  next_ += count;
  return Bytes(begin, begin + static_cast<std::ptrdiff_t>(count));
}

}  // namespace ratslam::fuzz
