#include "recordings.h"

#include "bags.h"

namespace ratslam {

std::unique_ptr<Recording> openRecording(const std::string& path, const RecordingOptions& options) {
  RecordingRegistry registry = folderRecordings();
  registry.add(bagRecordings());
  return registry.open(path, options);
}

}  // namespace ratslam
