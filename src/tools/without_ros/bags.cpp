#include "bags.h"

#include <filesystem>
#include <stdexcept>

namespace ratslam {
namespace {

[[noreturn]] void refuse(const std::string& path) {
  throw std::runtime_error(path + ": this program was built without ROS and knows no bags, only folders");
}

}  // namespace

RecordingKind bagRecordings() {
  RecordingKind kind;
  kind.what = "a folder, not a bag: this program was built without ROS";
  kind.recognises = [](const std::string& path, const RecordingOptions&) {
    return std::filesystem::is_regular_file(path);
  };
  kind.open = [](const std::string& path, const RecordingOptions&) -> std::unique_ptr<Recording> {
    refuse(path);
  };
  return kind;
}

std::unique_ptr<TownSink> makeBagSink(const TownOptions& options, const std::string&) { refuse(options.out); }

}  // namespace ratslam
