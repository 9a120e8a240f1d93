#include "output_paths.h"

#include <filesystem>

#include "ratslam/common/params.h"
#include "ratslam/common/paths.h"

namespace ratslam {

void requireApart(const std::vector<OptionPath>& read, const std::vector<OptionPath>& written) {
  for (auto file = written.begin(); file != written.end(); ++file) {
    for (const OptionPath& other : read) {
      if (std::filesystem::exists(other.path) && sameFile(file->path, other.path))
        throwBadValue(file->option, file->path, "it would take the place of " + other.option);
    }
    for (auto other = written.begin(); other != file; ++other) {
      if (sameFile(file->path, other->path))
        throwBadValue(file->option, file->path, "it would take the place of " + other->option);
    }
  }
}

}  // namespace ratslam
