/// Time in whole nanoseconds, like ROS stamps: conversions do not change a stamp, and differences are exact.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

namespace ratslam {

using Stamp = std::int64_t;  ///< [ns] since the epoch of the recording's clock

/// Time from `from` to `to` [s].
inline double secondsBetween(Stamp from, Stamp to) { return static_cast<double>(to - from) * 1e-9; }

/// Nearest stamp to a time in seconds.
inline Stamp stampFromSeconds(double seconds) { return static_cast<Stamp>(std::llround(seconds * 1e9)); }

/// A stamp [s]; exact to about a microsecond for present-day Unix times.
inline double toSeconds(Stamp stamp) { return static_cast<double>(stamp) * 1e-9; }

/// A stamp in seconds with nine decimals, exact: "1600000003.500000000".
std::string formatStamp(Stamp stamp);

}  // namespace ratslam
