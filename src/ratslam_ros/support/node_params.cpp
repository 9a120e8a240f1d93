#include "ratslam_ros/support/node_params.h"

#include <algorithm>
#include <vector>

namespace ratslam {
namespace {

void requireOneOf(const std::string& key, const std::string& value, const std::vector<std::string>& allowed) {
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return;
  std::string list;
  for (const std::string& choice : allowed) list += (list.empty() ? "" : ", ") + choice;
  throwBadValue(key, "'" + value + "'", "it must be one of " + list);
}

void requireFrame(const std::string& key, const std::string& value) {
  if (value.empty() || value.front() == '/') {
    throwBadValue(key, "'" + value + "'", "it must be the name of a tf2 frame, without a leading slash");
  }
}

/// Refuses two equal frames: every tf2 listener refuses a transform from a frame to itself, and transforms in a circle.
/// @throws std::invalid_argument
void requireOther(const std::string& key, const std::string& value, const std::string& other_key,
                  const std::string& other) {
  if (!value.empty() && value == other)
    throwBadValue(key, "'" + value + "'", "it must be another frame than " + other_key);
}

}  // namespace

std::string NodeParams::odomFrame(const std::string& in_messages) const {
  if (!odom_frame.empty()) return odom_frame;
  return in_messages.empty() ? "odom" : in_messages;
}

void NodeParams::validate() const {
  checkBounds(*this);
  requireOneOf("image_transport", image_transport, {"raw", "compressed"});
  requireOneOf("stamp_source", stamp_source, {"header", "arrival"});
  requireOneOf("decision_source", decision_source, {"auto", "state", "action"});
  requireOneOf("trajectory_format", trajectory_format, {"tum", "kitti"});
  if (!map_frame.empty()) requireFrame("map_frame", map_frame);
  if (!odom_frame.empty()) requireFrame("odom_frame", odom_frame);
  requireFrame("base_frame", base_frame);
  if (publish_tf) {
    requireOther("map_frame", map_frame, "odom_frame", odom_frame);
    requireOther("map_frame", map_frame, "base_frame", base_frame);
    requireOther("base_frame", base_frame, "odom_frame", odom_frame);
  }
}

}  // namespace ratslam
