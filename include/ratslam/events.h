/// The events that the models exchange. The ROS topics carry the same data.
#pragma once

#include <cstdint>

#include "ratslam/common/stamp.h"

namespace ratslam {

/// Session of a process that numbers views or experiences. A later session may give the same numbers to other
/// things. So a receiver that keeps such numbers must drop those that the later session does not know.
struct NumberSession {
  Stamp id = 0;             ///< stamp of the first message that the process handled; 0: unknown
  std::uint32_t known = 0;  ///< lower numbers were loaded: they are older than the session

  bool operator==(const NumberSession& other) const { return id == other.id && known == other.known; }
  bool operator!=(const NumberSession& other) const { return !(*this == other); }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("id", id);
    fields("known", known);
  }
};

/// View number of an image that shows nothing: no view cell is active.
constexpr std::uint32_t kNoView = 0xFFFFFFFF;

/// The view cell that an image made active (topic LocalView/Template).
struct ViewEvent {
  Stamp stamp = 0;            ///< of the image
  std::uint32_t id = 0;       ///< number of the active view cell and of its template; or kNoView
  double relative_rad = 0.0;  ///< heading now relative to the heading when the template was learned [rad]
  double error = -1.0;        ///< error of the best candidate; -1 if there was no candidate
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

/// Decision of the pose cells about the map (topic PoseCell/TopologicalAction).
struct TopologicalAction {
  Stamp stamp = 0;
  ActionKind kind = ActionKind::kNone;
  std::uint32_t src_id = 0;   ///< current experience before the decision
  std::uint32_t dest_id = 0;  ///< current experience after the decision
  double relative_rad = 0.0;  ///< heading now relative to the heading of dest_id [rad]
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

/// Source of the pose of an image relative to the recalled template.
enum class GeometrySource {
  kNone,
  kLikeness,  ///< only the distance ahead, from the similarity of the neighbouring templates
  kImages     ///< also image geometry
};

/// Pose of an image relative to the image that the recalled template was learned from: measured by image geometry, or
/// estimated from the similarity of the neighbouring templates.
///
/// A monocular camera measures the heading and the direction of the offset. It measures the length of the offset only
/// as a ratio to another length: the distance from a companion image, seen shortly before the template's image, to
/// the template's image. The odometry between those two stamps turns the ratio into `distance`.
struct RecallGeometry {
  Stamp stamp = 0;
  std::uint32_t view_id = 0;     ///< template that was recalled
  double relative_rad = 0.0;     ///< heading now relative to the heading then [rad]
  double direction_rad = 0.0;    ///< direction of the offset (now minus then) in the robot's axes then [rad]
  double distance = -1.0;        ///< length of the offset in the odometry's unit, negative where unknown
  double sigma_distance = 0.0;   ///< standard deviation of distance
  double sigma_rotation = 0.05;  ///< standard deviation of relative_rad [rad]
  double sigma_direction = 0.1;  ///< standard deviation of direction_rad [rad]
  int inliers = 0;               ///< feature matches that agree with the geometry; 0: nothing was measured
  Stamp template_stamp = 0;      ///< of the image from which the template was learned
  Stamp companion_stamp = 0;     ///< of the companion image; equal to template_stamp if there is none
  double distance_ratio = -1.0;  ///< length of the offset / distance companion -> template; negative: unknown
  double sigma_ratio = 0.0;      ///< standard deviation of distance_ratio
  /// Distance of the robot ahead of the template's place, along the path driven then, estimated from the similarity
  /// of the templates before and after it, in the odometry's unit [m]; 0: unknown.
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
