// Opening of recordings of any kind.
#pragma once

#include <memory>
#include <string>

#include "ratslam/dataset/registry.h"

namespace ratslam {

/// Opens a folder or a bag.
/// @throws std::runtime_error naming what is missing, or listing the kinds of recordings
std::unique_ptr<Recording> openRecording(const std::string& path, const RecordingOptions& options);

}  // namespace ratslam
