#include "ratslam/camera/calibration_file.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "ratslam/common/parameter_map.h"

namespace ratslam {
namespace {

struct Intrinsics {
  int width = 0;
  int height = 0;
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  std::array<double, 5> distortion{};

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("image_width", width, Bounds{1, 65535}, "[px]");
    visit("image_height", height, Bounds{1, 65535}, "[px]");
    visit("fx", fx, Bounds{1e-3, 1e6}, "focal length along x [px]");
    visit("fy", fy, Bounds{1e-3, 1e6}, "focal length along y [px]");
    visit("cx", cx, Bounds{-1e6, 1e6}, "principal point [px]");
    visit("cy", cy, Bounds{-1e6, 1e6}, "principal point [px]");
    constexpr std::array<const char*, 5> kKeys{"k1", "k2", "p1", "p2", "k3"};
    for (std::size_t i = 0; i < kKeys.size(); ++i) visit(kKeys[i], distortion[i], Bounds{}, "distortion");
  }
  void validate() const { checkBounds(*this); }
};

CameraModel modelOf(const ParameterMap& map) {
  Intrinsics camera;
  map.read(camera);
  CameraModel model{camera.width, camera.height, camera.fx,        camera.fy,
                    camera.cx,    camera.cy,     LensModel::kNone, {}};
  if (std::any_of(camera.distortion.begin(), camera.distortion.end(), [](double k) { return k != 0.0; })) {
    model.model = LensModel::kPlumbBob;
    model.coefficients.assign(camera.distortion.begin(), camera.distortion.end());
  }
  model.validate();
  return model;
}

}  // namespace

CameraModel readCalibration(const std::string& path) {
  const ParameterMap map = ParameterMap::fromYaml(path);
  map.rejectUnknown(keysOf<Intrinsics>());
  for (const char* key : {"image_width", "image_height", "fx", "fy", "cx", "cy"}) {
    if (!map.has(key)) throw std::runtime_error(path + ": no " + key + ", without which there is no camera");
  }
  try {
    return modelOf(map);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace ratslam
