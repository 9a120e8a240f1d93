/// Settings of the ORB odometry; keys as in configuration files.
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "ratslam/common/params.h"

namespace ratslam {

struct OrbOdometryParams {
  int features = 2000;
  int levels = 8;
  double scale_factor = 1.2;
  int fast_threshold = 20;
  int fast_min_threshold = 7;
  double camera_height = 0.0;
  bool ground_plane = true;
  double camera_pitch_deg = 0.0;
  double camera_roll_deg = 0.0;
  double camera_yaw_deg = 0.0;
  double camera_x = 0.0;
  double camera_y = 0.0;
  double camera_z = 0.0;
  std::string camera_frame;
  bool refine_lens = true;
  double nominal_speed = 0.0;
  int window_keyframes = 8;
  int fixed_keyframes = 12;
  int map_keyframes = 25;
  double keyframe_baseline = 0.015;
  int new_landmarks = 300;
  double init_parallax_deg = 1.0;
  int init_points = 80;
  double min_parallax_deg = 1.0;
  double outlier_gate = 12.0;
  int min_tracked = 25;
  double coast_time = 0.5;
  double relocalisation_time = 0.5;
  int relocalisation_inliers = 50;
  int threads = 2;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("orb_features", features, Bounds{100, 20000}, "features per image");
    visit("orb_levels", levels, Bounds{1, 16}, "levels of the image pyramid");
    visit("orb_scale_factor", scale_factor, Bounds{1.05, 2.0}, "scale between pyramid levels");
    visit("orb_fast_threshold", fast_threshold, Bounds{1, 255}, "corner threshold [grey levels]");
    visit("orb_fast_min_threshold", fast_min_threshold, Bounds{1, 255},
          "corner threshold where a grid cell has no stronger corner [grey levels]");
    visit("camera_height", camera_height, Bounds{0.0, 100.0},
          "height of the camera above the road [m]; 0: unknown");
    visit("orb_ground_plane", ground_plane, Bounds{},
          "correct scale drift by the road plane; without camera_height the scale at the start is kept");
    visit("camera_pitch_deg", camera_pitch_deg, Bounds{-60.0, 60.0},
          "angle by which the camera looks down [deg]");
    visit("camera_roll_deg", camera_roll_deg, Bounds{-180.0, 180.0},
          "angle by which the camera is turned clockwise about its optical axis [deg]");
    visit("camera_yaw_deg", camera_yaw_deg, Bounds{-180.0, 180.0},
          "angle by which the camera looks to the left [deg]");
    visit("camera_x", camera_x, Bounds{-100.0, 100.0}, "position of the camera in base_link, forward [m]");
    visit("camera_y", camera_y, Bounds{-100.0, 100.0},
          "position of the camera in base_link, to the left [m]");
    visit("camera_z", camera_z, Bounds{-100.0, 100.0}, "position of the camera in base_link, up [m]");
    visit(
        "camera_frame", camera_frame, Bounds{},
        "the camera's optical frame (x right, y down, z forward): ratslam_orb_vo reads the mount from the tf "
        "base_frame -> camera_frame; empty: camera_x ... camera_yaw_deg hold");
    visit("orb_refine_lens", refine_lens, Bounds{},
          "estimate the radial and tangential distortion that the calibration has left, and correct it");
    visit("nominal_speed", nominal_speed, Bounds{0.0, 1000.0},
          "speed assumed while a map starts and camera_height is unknown [m/s]; 0: the median depth counts "
          "as 1 m");
    visit("orb_window_keyframes", window_keyframes, Bounds{2, 50},
          "keyframes that bundle adjustment refines together");
    visit("orb_fixed_keyframes", fixed_keyframes, Bounds{1, 100}, "older keyframes held fixed beside them");
    visit("orb_map_keyframes", map_keyframes, Bounds{3, 500}, "keyframes kept in the local map");
    visit("orb_keyframe_baseline", keyframe_baseline, Bounds{0.0, 1.0},
          "a keyframe is taken after moving by this share of the median depth");
    visit("orb_new_landmarks", new_landmarks, Bounds{10, 5000}, "most landmarks added by a keyframe");
    visit("orb_init_parallax_deg", init_parallax_deg, Bounds{0.1, 20.0},
          "parallax needed to start a map [deg]");
    visit("orb_init_points", init_points, Bounds{20, 5000}, "points needed to start a map");
    visit("orb_min_parallax_deg", min_parallax_deg, Bounds{0.1, 20.0},
          "least parallax of a new landmark [deg]");
    visit("orb_outlier_gate", outlier_gate, Bounds{4.0, 50.0},
          "squared reprojection error of an outlier [sigma^2]");
    visit("orb_min_tracked", min_tracked, Bounds{6, 1000}, "with fewer tracked landmarks tracking is lost");
    visit("orb_coast_time", coast_time, Bounds{0.0, 10.0},
          "longest time at the last velocity after tracking is lost [s]");
    visit("orb_relocalisation_time", relocalisation_time, Bounds{0.0, 60.0},
          "longest search for the map after that, before a new map starts [s]");
    visit("orb_relocalisation_inliers", relocalisation_inliers, Bounds{10, 1000},
          "landmarks that relocalisation must find again");
    visit("threads", threads, Bounds{1, 64},
          "threads that share the work on an image; the results do not depend on it");
  }
  /// Camera axes (x right, y down, z forward) in base_link, turned by yaw, then pitch, then roll.
  Eigen::Isometry3d baseFromCamera() const;
  /// Sets position and angles so that baseFromCamera() returns T. @param T camera axes in base_link
  void setBaseFromCamera(const Eigen::Isometry3d& T);

  /// @throws std::invalid_argument naming key, value and bound.
  void validate() const;
  /// To be called by programs without tf. @throws std::invalid_argument if camera_frame is set
  void requireNoCameraFrame() const;
};

}  // namespace ratslam
