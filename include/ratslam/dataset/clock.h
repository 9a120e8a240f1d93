/// A recording's clock that was set back while it ran: by the network's time, or by hand.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ratslam/common/stamp.h"

namespace ratslam {

struct ClockJump {
  Stamp first = 0;  ///< of the first image after it
  Stamp back = 0;   ///< by how much [ns]
};

/// @param images  stamp and name in the order of their file, which is that of their recording
/// @return none where the clock was not set back: single late lines, repeated lines and files in no order are
/// none of it. scripts/ratslam_tools/datasets/clock.py judges the same.
std::optional<ClockJump> clockSetBack(const std::vector<std::pair<Stamp, std::string>>& images);

}  // namespace ratslam
