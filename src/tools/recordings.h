// Opens whatever a user may call a recording.
#pragma once

#include <memory>
#include <string>

#include "ratslam/dataset/registry.h"

namespace ratslam {

/// A folder that the core reads, or a bag.
/// @throws std::runtime_error saying what is missing, or what a recording may be
std::unique_ptr<Recording> openRecording(const std::string& path, const RecordingOptions& options);

}  // namespace ratslam
