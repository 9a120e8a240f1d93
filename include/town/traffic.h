/// Cars under way on the driven road: oncoming ones in the other lane, and cars in front that are caught up
/// with and drive off again. They are disturbance, not truth: nothing of them is written.
#pragma once

#include <vector>

#include "town/drive.h"
#include "town/mesh.h"
#include "town/road_field.h"
#include "town/texture_library.h"

namespace ratslam {

class Traffic {
 public:
  /// @param drive,roads,textures must outlive the traffic. @param cars their number over the whole drive;
  /// every fourth drives in front of the camera for about a minute, the others meet it at some time.
  Traffic(const Drive& drive, const RoadField& roads, const TextureLibrary& textures, int cars,
          std::uint64_t seed);
  /// The cars to be seen at a frame.
  std::vector<MeshTriangle> at(std::size_t frame) const;

 private:
  struct Car {
    bool in_front;
    double time;   ///< when it is met, or nearest in front [s]
    double way;    ///< path length of the camera at that time [m]
    double speed;  ///< of an oncoming car [m/s]
    std::uint64_t kind;
  };
  const Drive& drive_;
  const RoadField& roads_;
  const TextureLibrary& textures_;
  std::vector<double> way_;  ///< driven up to each frame [m]
  std::vector<Car> cars_;
};

}  // namespace ratslam
