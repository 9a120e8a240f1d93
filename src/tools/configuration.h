// The parameters that a command line gives.
#pragma once

#include <string>
#include <vector>

#include "ratslam/common/parameter_map.h"

namespace ratslam {

/// Reads the configuration file; the assignments key=value override it. Remarks about it are printed to stdout.
/// @throws std::exception naming what is wrong, or that there is neither a file nor an assignment
ParameterMap readConfiguration(const std::string& program, const std::string& file,
                               const std::vector<std::string>& assignments);

}  // namespace ratslam
