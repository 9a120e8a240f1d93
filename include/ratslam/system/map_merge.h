/// One map of two: what two drives have learned, joined where they share places.
///
/// The map that began first stays as it is. The drive of the other is driven through it once more, as far as its map
/// has kept it: its path as odometry, and at each place the view that was learned there. So the merged map is
/// made by the same stages, with the same care about recalls, as if the second drive had gone on in the first map; what is
/// shared is recalled, not learned twice, and stretches that share nothing stay components of their own.
#pragma once

#include <cstddef>

#include "ratslam/system/map_store.h"

namespace ratslam {

/// What came of a merge.
struct MapMerge {
  MapCheckpoint map;
  std::size_t first_experiences = 0;   ///< of the map that began first
  std::size_t second_experiences = 0;  ///< of the other
  std::size_t experiences = 0;         ///< of both together
  std::size_t components = 0;          ///< of the merged map: places joined by links
};

/// In either order the same map, to the last bit.
/// @throws std::runtime_error where parameters differ, a part is missing, or recalls are verified by images (vt_verify),
/// which a map does not keep
MapMerge mergeMaps(const MapCheckpoint& a, const MapCheckpoint& b);

}  // namespace ratslam
