/// A whole synthetic drive, from options to frames in a sink.
#pragma once

#include <functional>

#include "town/town_options.h"
#include "town/town_sink.h"

namespace ratslam {

struct TownSummary {
  int frames = 0;        ///< written
  double way = 0.0;      ///< driven [m]
  double seconds = 0.0;  ///< of driving
};

/// Told after each frame how many are done, of how many; false ends the drive early.
using TownProgress = std::function<bool(int done, int total)>;

/// Builds the town, drives through it and hands every frame to the sink.
/// The frames are a function of the options alone; threads do not change them.
/// @throws std::invalid_argument for bad options and trajectories; std::runtime_error if a trajectory cannot be read; what
/// the sink throws.
TownSummary runTown(const TownOptions& options, TownSink& sink, const TownProgress& progress);

}  // namespace ratslam
