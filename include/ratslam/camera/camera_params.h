/// Parameters with a camera's calibration, for recordings and drivers that bring none.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/common/params.h"

namespace ratslam {

struct CameraParams {
  int width = 0;
  int height = 0;
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  std::string distortion_model = "plumb_bob";
  std::vector<double> distortion;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("camera_width_px", width, Bounds{0, 65535}, "calibrated image width [px]");
    visit("camera_height_px", height, Bounds{0, 65535}, "calibrated image height [px]");
    visit("camera_fx", fx, Bounds{0, 1e6}, "focal length along x [px]; 0: no calibration is given");
    visit("camera_fy", fy, Bounds{0, 1e6}, "focal length along y [px]");
    visit("camera_cx", cx, Bounds{-1e6, 1e6}, "x of the principal point [px]");
    visit("camera_cy", cy, Bounds{-1e6, 1e6}, "y of the principal point [px]");
    visit("camera_distortion_model", distortion_model, Bounds{},
          "plumb_bob, rational_polynomial or equidistant");
    visit("camera_distortion", distortion, Bounds{},
          "coefficients of the distortion model, in OpenCV's order");
  }

  /// @throws std::invalid_argument naming key, value and requirement
  void validate() const {
    checkBounds(*this);
    try {
      lensModelFromName(distortion_model);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(std::string("camera_") + error.what());
    }
    if (fx > 0.0) {
      model();
    } else {
      refusePart();
    }
  }

  /// The calibration; none if none is given. @throws std::invalid_argument naming a value that no
  /// camera can have
  std::optional<CameraModel> model() const {
    if (fx <= 0.0) return std::nullopt;
    try {
      return makeCamera({width, height, fx, fy, cx, cy, LensModel::kNone, {}}, distortion_model, distortion);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(
          std::string("camera_width_px, camera_height_px, camera_fx ... camera_distortion: ") + error.what());
    }
  }

 private:
  /// Refuses a calibration without camera_fx, which would be ignored. @throws std::invalid_argument
  void refusePart() const {
    const std::string requirement =
        "it has no effect without camera_fx; give the whole calibration, or none of it";
    if (width != 0) throwBadValue("camera_width_px", width, requirement);
    if (height != 0) throwBadValue("camera_height_px", height, requirement);
    if (fy != 0.0) throwBadValue("camera_fy", fy, requirement);
    if (cx != 0.0) throwBadValue("camera_cx", cx, requirement);
    if (cy != 0.0) throwBadValue("camera_cy", cy, requirement);
    if (!distortion.empty()) throwBadValue("camera_distortion[0]", distortion.front(), requirement);
  }
};

}  // namespace ratslam
