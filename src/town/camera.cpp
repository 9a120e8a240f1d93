#include "town/camera.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/params.h"

namespace ratslam {

TownCamera TownCamera::kittiLike(int width, int height) {
  TownCamera camera;
  const double scale = static_cast<double>(width) / camera.width;
  camera.cy *= static_cast<double>(height) / camera.height;
  camera.fx *= scale;
  camera.fy *= scale;
  camera.cx *= scale;
  camera.width = width;
  camera.height = height;
  return camera;
}

bool TownCamera::distorted() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0.0; });
}

void TownCamera::validate() const {
  const auto check = [](const char* key, double value, double min, double max, const char* requirement) {
    if (!(value >= min && value <= max)) throwBadValue(key, value, requirement);
  };
  check("width", width, 16, 8192, "it must lie within [16, 8192]");
  check("height", height, 16, 8192, "it must lie within [16, 8192]");
  check("fx", fx, 0.1 * width, 20.0 * width, "it must lie within 0.1 and 20 image widths");
  check("fy", fy, 0.1 * width, 20.0 * width, "it must lie within 0.1 and 20 image widths");
  check("cx", cx, 0, width, "it must lie in the image");
  check("cy", cy, 0, height, "it must lie in the image");
  constexpr std::array<const char*, 5> kKeys{"k1", "k2", "p1", "p2", "k3"};
  for (std::size_t i = 0; i < kKeys.size(); ++i)
    check(kKeys[i], distortion[i], -2.0, 2.0, "it must lie within [-2, 2]");
}

}  // namespace ratslam
