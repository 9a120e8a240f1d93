/// The events that the models exchange, as the topics of the ROS graph carry them.
#pragma once

#include <cstdint>

#include "ratslam/common/stamp.h"

namespace ratslam {

/// The life of one process that numbers things: views, or experiences. Whoever keeps such numbers drops or
/// renews what a later session does not know, because that one gives the same numbers to other things.
struct NumberSession {
  Stamp id = 0;             ///< stamp of the first message it handled; 0: it does not say
  std::uint32_t known = 0;  ///< numbers below were given, and are known, from before it began

  bool operator!=(const NumberSession& other) const { return id != other.id || known != other.known; }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("id", id);
    fields("known", known);
  }
};

/// The number of the view where an image shows nothing: no view cell is active.
constexpr std::uint32_t kNoView = 0xFFFFFFFF;

/// The view cell that an image made active (topic LocalView/Template).
struct ViewEvent {
  Stamp stamp = 0;            ///< of the image
  std::uint32_t id = 0;       ///< the active view cell, which is also its template's number; or kNoView
  double relative_rad = 0.0;  ///< heading now relative to the heading when the template was learned [rad]
  double error = -1.0;        ///< error of the best candidate, -1 where no template was one
  bool learned = false;       ///< the template is new
  NumberSession session;      ///< of the views' numbers

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("stamp", stamp);
    fields("id", id);
    fields("relative_rad", relative_rad);
    fields("error", error);
    fields("learned", learned);
    fields("session", session);
  }

  bool seen() const { return id != kNoView; }
};

enum class ActionKind : std::uint32_t { kNone = 0, kCreateNode = 1, kCreateEdge = 2, kSetNode = 3 };

/// What the pose cells decide about the map (topic PoseCell/TopologicalAction).
struct TopologicalAction {
  Stamp stamp = 0;
  ActionKind kind = ActionKind::kNone;
  std::uint32_t src_id = 0;   ///< experience that was current
  std::uint32_t dest_id = 0;  ///< experience that is current now
  double relative_rad = 0.0;  ///< heading now relative to that of the destination [rad]
  NumberSession session;      ///< of the experiences' numbers

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("stamp", stamp);
    fields("kind", kind);
    fields("src_id", src_id);
    fields("dest_id", dest_id);
    fields("relative_rad", relative_rad);
    fields("session", session);
  }
};

/// What tells where an image was taken relative to the recalled one.
enum class GeometrySource {
  kNone,
  kLikeness,  ///< only how far ahead, by the views learned around it
  kImages     ///< image geometry as well
};

/// Where an image was taken, relative to where the matched template was learned, as image geometry measured
/// it, or as the likeness of the views around it tells.
///
/// A monocular camera measures heading, the direction of the offset, and its length only in comparison with
/// another length: the way from a companion image, seen shortly before the template's, to the template's
/// image. Whoever knows the odometry between those two stamps turns the ratio into `distance`.
struct RecallGeometry {
  Stamp stamp = 0;
  std::uint32_t view_id = 0;     ///< template that was recalled
  double relative_rad = 0.0;     ///< heading now relative to the heading then [rad]
  double direction_rad = 0.0;    ///< direction of the offset (now minus then) in the axes of then [rad]
  double distance = -1.0;        ///< length of the offset in the odometry's unit, negative where unknown
  double sigma_distance = 0.0;   ///< standard deviation of distance
  double sigma_rotation = 0.05;  ///< standard deviation of relative_rad [rad]
  double sigma_direction = 0.1;  ///< standard deviation of direction_rad [rad]
  int inliers = 0;               ///< feature matches that agree with the geometry; 0: nothing was measured
  Stamp template_stamp = 0;      ///< of the image from which the template was learned
  Stamp companion_stamp = 0;     ///< of the companion image; equal to template_stamp where there is none
  double distance_ratio =
      -1.0;  ///< length of the offset / length of the way companion -> template, negative: unknown
  double sigma_ratio = 0.0;  ///< standard deviation of distance_ratio
  /// How far ahead of the place of the template the robot is on the way that was driven then, by how like the view is
  /// to those learned before and after it, in the odometry's unit [m]; 0 where they do not tell.
  double ahead = 0.0;

  /// Whether image geometry measured anything.
  bool measured() const { return inliers > 0; }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("stamp", stamp);
    fields("view_id", view_id);
    fields("relative_rad", relative_rad);
    fields("direction_rad", direction_rad);
    fields("distance", distance);
    fields("sigma_distance", sigma_distance);
    fields("sigma_rotation", sigma_rotation);
    fields("sigma_direction", sigma_direction);
    fields("inliers", inliers);
    fields("template_stamp", template_stamp);
    fields("companion_stamp", companion_stamp);
    fields("distance_ratio", distance_ratio);
    fields("sigma_ratio", sigma_ratio);
    fields("ahead", ahead);
  }
};

}  // namespace ratslam
