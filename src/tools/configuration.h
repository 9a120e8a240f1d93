// The parameters that a command line gives.
#pragma once

#include <string>
#include <vector>

#include "ratslam/common/parameter_map.h"

namespace ratslam {

/// The configuration file with the assignments key=value on top; what it leaves out or implies is said on stdout.
/// @throws std::exception naming what is wrong, or that there is neither a file nor an assignment
ParameterMap readConfiguration(const std::string& program, const std::string& file,
                               const std::vector<std::string>& assignments);

}  // namespace ratslam
