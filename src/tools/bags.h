// What the tools can do with bags. A build without ROS has the same functions, which say that it knows none.
#pragma once

#include <memory>
#include <string>

#include "ratslam/dataset/registry.h"
#include "town/town_sink.h"

namespace ratslam {

/// Takes whatever is no folder, so that a file that is no bag is told so.
RecordingKind bagRecordings();

/// Writes a synthetic drive as a bag. @param root namespace of its topics
/// @throws std::runtime_error where options.out cannot be written
std::unique_ptr<TownSink> makeBagSink(const TownOptions& options, const std::string& root);

}  // namespace ratslam
