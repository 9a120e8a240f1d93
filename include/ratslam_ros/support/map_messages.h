/// The experience map as messages: topology, marker, robot pose, path. Positions in metres of the map.
#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <nav_msgs/Path.h>
#include <visualization_msgs/Marker.h>

#include <Eigen/Core>
#include <boost/array.hpp>
#include <vector>

#include "ratslam/experience_map/experience_graph.h"
#include "ratslam_ros/TopologicalMap.h"

namespace ratslam {

geometry_msgs::Pose poseToMessage(const MapPose& pose);

/// Converts a covariance of (x, y, z, yaw) to that of a message: (x, y, z, roll, pitch, yaw). Roll and pitch come from
/// the odometry; their standard deviation is about a degree.
boost::array<double, 36> covarianceToMessage(const Eigen::Matrix4d& covariance);

/// All experiences and links. A link's transform is the measured pose of its destination in the frame of its source,
/// converted from the odometry's unit to the map's by the source's scale.
ratslam_ros::TopologicalMap mapToMessage(const ExperienceGraph& graph, const std_msgs::Header& header);

/// A LINE_LIST of the links: driven ones and, in another colour, those by recall.
visualization_msgs::Marker markerToMessage(const ExperienceGraph& graph, const std_msgs::Header& header,
                                           double line_width);

nav_msgs::Path pathToMessage(const std::vector<MapPose>& poses, const std_msgs::Header& header);

}  // namespace ratslam
