/// Merges two maps into one, which is joined at the places that both have.
///
/// The map that began first is kept. The drive of the other map is replayed through it: the stored path serves as
/// odometry, and at each place the view learned there is shown. So the same stages make the merged map, as if the
/// second drive had continued in the first map. Common places are recalled and not learned twice. Parts without common
/// places stay separate components.
#pragma once

#include <cstddef>

#include "ratslam/system/map_store.h"

namespace ratslam {

/// Result of a merge.
struct MapMerge {
  MapCheckpoint map;
  std::size_t first_experiences = 0;   ///< experiences of the map that began first
  std::size_t second_experiences = 0;  ///< experiences of the other map
  std::size_t experiences = 0;         ///< experiences of the merged map
  std::size_t components = 0;          ///< connected components of the merged map
};

/// Merges two maps that were made with the same parameters (requireParameters). The order of the arguments does not
/// change a bit of the result.
/// @throws std::runtime_error if a part is missing, both hold the same drive, or recalls are verified by images
/// (vt_verify), which a map does not contain
MapMerge mergeMaps(const MapCheckpoint& a, const MapCheckpoint& b);

}  // namespace ratslam
