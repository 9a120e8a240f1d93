// The tools' functions for bags. In a build without ROS they report that bags are not supported.
#pragma once

#include <memory>
#include <string>

#include "ratslam/dataset/registry.h"
#include "town/town_sink.h"

namespace ratslam {

/// Recognises every file, so that a file which is no bag gets a clear error.
RecordingKind bagRecordings();

/// Writes a synthetic drive as a bag. @param root namespace of its topics
/// @throws std::runtime_error if options.out cannot be written
std::unique_ptr<TownSink> makeBagSink(const TownOptions& options, const std::string& root);

}  // namespace ratslam
