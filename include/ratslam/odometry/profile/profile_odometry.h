/// RatSLAM's own visual odometry: intensity profiles of consecutive images (docs/model.md section 4; Milford & Wyeth
/// 2008).
///
/// 1. An image region becomes a profile: the mean intensity of each of its columns, in [0,1].
/// 2. The profile is compared with the one before at shifts of up to 40 columns: mean absolute difference over
///    the overlap.
/// 3. Yaw rate: in the rotation region, the shift of the smallest difference is the turn in pixels.
/// 4. Speed: in the translation region, the smallest difference itself grows with speed.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ratslam/common/params.h"
#include "ratslam/common/pose2.h"
#include "ratslam/odometry/odometry.h"

namespace ratslam {

class State;

struct ProfileOdometryParams {
  int vtrans_x_min = 0;  ///< translation region [px]; -1 as max means the image's edge
  int vtrans_x_max = -1;
  int vtrans_y_min = 0;
  int vtrans_y_max = -1;
  int vrot_x_min = 0;  ///< rotation region [px]
  int vrot_x_max = -1;
  int vrot_y_min = 0;
  int vrot_y_max = -1;
  double fov_deg = 50.0;          ///< horizontal field of view of the whole image [deg]
  double camera_hz = 10.0;        ///< frame rate assumed where stamps do not increase [1/s]
  double vtrans_scaling = 100.0;  ///< speed per unit of profile difference [m/s]
  double vtrans_max = 20.0;       ///< highest speed [m/s]
  bool subpixel = false;          ///< refine the shift by a parabola through the neighbouring differences

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    const Bounds pixel{0, 100000};
    const Bounds pixel_or_edge{-1, 100000};
    visit("vtrans_image_x_min", vtrans_x_min, pixel, "translation region, first column [px]");
    visit("vtrans_image_x_max", vtrans_x_max, pixel_or_edge, "translation region, end column [px], -1: edge");
    visit("vtrans_image_y_min", vtrans_y_min, pixel, "translation region, first row [px]");
    visit("vtrans_image_y_max", vtrans_y_max, pixel_or_edge, "translation region, end row [px], -1: edge");
    visit("vrot_image_x_min", vrot_x_min, pixel, "rotation region, first column [px]");
    visit("vrot_image_x_max", vrot_x_max, pixel_or_edge, "rotation region, end column [px], -1: edge");
    visit("vrot_image_y_min", vrot_y_min, pixel, "rotation region, first row [px]");
    visit("vrot_image_y_max", vrot_y_max, pixel_or_edge, "rotation region, end row [px], -1: edge");
    visit("camera_fov_deg", fov_deg, Bounds{1, 360}, "horizontal field of view of the whole image [deg]");
    visit("camera_hz", camera_hz, Bounds{1e-3, 1e4},
          "frame rate assumed between images whose stamps do not increase [1/s]");
    visit("vtrans_scaling", vtrans_scaling, Bounds{0, 1e9}, "speed per unit of profile difference [m/s]");
    visit("vtrans_max", vtrans_max, Bounds{0, 1e6}, "highest speed [m/s]");
    visit("vrot_subpixel", subpixel, Bounds{}, "refine the shift between columns by a parabola");
  }
  /// @throws std::invalid_argument naming key, value and bound
  void validate() const;
};

class ProfileOdometry {
 public:
  /// @throws std::invalid_argument for bad parameters
  explicit ProfileOdometry(const ProfileOdometryParams& params);

  /// Motion since the image before. The first image has no motion.
  /// @param image  8- or 16-bit, 1, 3 or 4 channels, any row stride
  /// @throws std::invalid_argument if a region lies outside the image or the size of the images changes
  OdometrySample track(Stamp stamp, const cv::Mat& image);

  /// Predicted motion up to the stamp of a frozen or blank image: straight on at the last speed. The motion up
  /// to the next usable image is predicted in the same way.
  OdometrySample bridge(Stamp stamp);

  /// Forgets the last image, for example when time has gone back. The pose stays.
  void restart();

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing
  void load(const State& state);

 private:
  using Profile = std::vector<double>;
  struct View {
    Stamp stamp = 0;
    cv::Size size;
    Profile rotation;
    Profile translation;

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("width", size.width);
      fields("height", size.height);
      fields("rotation", rotation);
      fields("translation", translation);
    }
  };

  TwistCovariance covariance(double speed, int image_columns, double dt) const;
  double secondsSince(Stamp before, Stamp now) const;
  /// Moves the pose by the sample's twist and notes it there.
  void finish(OdometrySample& sample, double dt);

  ProfileOdometryParams params_;
  std::optional<View> previous_;
  std::optional<Stamp>
      bridged_from_;  ///< stamp of the last measured image before bridge(), until the next track()
  std::optional<Stamp> bridged_to_;  ///< stamp of the last bridge(), until the next track()
  double speed_ = 0.0;               ///< of the last sample [m/s]
  Pose2 pose_;
};

}  // namespace ratslam
