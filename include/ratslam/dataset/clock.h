/// Detection of a clock that was set back during a recording, by the network's time or by hand.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ratslam/common/stamp.h"

namespace ratslam {

struct ClockJump {
  Stamp first = 0;  ///< stamp of the first image after the jump
  Stamp back = 0;   ///< size of the jump [ns]
};

/// @param images  stamp and name in the order of recording
/// @return none if the clock was not set back. Single late lines, repeated lines and files without order are no jump.
/// scripts/ratslam_tools/datasets/clock.py uses the same rules.
std::optional<ClockJump> clockSetBack(const std::vector<std::pair<Stamp, std::string>>& images);

}  // namespace ratslam
