/// The experience map as messages: topology, marker, robot pose, path. Positions in metres of the map.
#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <nav_msgs/Path.h>
#include <visualization_msgs/Marker.h>

#include <vector>

#include "ratslam/experience_map/experience_graph.h"
#include "ratslam_ros/TopologicalMap.h"

namespace ratslam {

geometry_msgs::Pose poseToMessage(const MapPose& pose);

/// All experiences and links; a link's transform is where it says its destination is, in the frame of its
/// source, brought from the odometry's unit to the map's by the source's scale.
ratslam_ros::TopologicalMap mapToMessage(const ExperienceGraph& graph, const std_msgs::Header& header);

/// A LINE_LIST of the links: driven ones and, in another colour, those made by recalling a place.
visualization_msgs::Marker markerToMessage(const ExperienceGraph& graph, const std_msgs::Header& header,
                                           double line_width);

nav_msgs::Path pathToMessage(const std::vector<MapPose>& poses, const std_msgs::Header& header);

}  // namespace ratslam
