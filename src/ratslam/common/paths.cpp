#include "ratslam/common/paths.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace ratslam {

namespace fs = std::filesystem;

bool sameFile(const std::string& a, const std::string& b) {
  if (a.empty() || b.empty()) return false;
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;
  const auto place = [&error](const std::string& path) {
    return fs::weakly_canonical(fs::absolute(path, error), error);
  };
  return place(a) == place(b);
}

std::string withHome(const std::string& path) {
  const char* const home = std::getenv("HOME");
  const bool at_home = path == "~" || path.rfind("~/", 0) == 0;
  return at_home && home != nullptr ? home + path.substr(1) : path;
}

}  // namespace ratslam
