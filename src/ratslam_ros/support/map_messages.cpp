#include "ratslam_ros/support/map_messages.h"

#include <algorithm>
#include <cmath>

#include "ratslam_ros/support/conversions.h"

namespace ratslam {
namespace {

constexpr double kLongest = 2147483647.0;  // [s], of a ros::Duration

geometry_msgs::Point pointToMessage(const MapPose& pose) {
  geometry_msgs::Point message;
  message.x = pose.x;
  message.y = pose.y;
  message.z = pose.z;
  return message;
}

std_msgs::ColorRGBA colour(float red, float green, float blue) {
  std_msgs::ColorRGBA message;
  message.r = red;
  message.g = green;
  message.b = blue;
  message.a = 1.0F;
  return message;
}

}  // namespace

geometry_msgs::Pose poseToMessage(const MapPose& pose) {
  geometry_msgs::Pose message;
  message.position = pointToMessage(pose);
  message.orientation = yawToMessage(pose.yaw);
  return message;
}

boost::array<double, 36> covarianceToMessage(const Eigen::Matrix4d& covariance) {
  constexpr double kTilt = 0.02;  // [rad]
  const int parts[] = {0, 1, 2, 5};
  boost::array<double, 36> message;
  message.fill(0.0);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      message[static_cast<std::size_t>(6 * parts[row] + parts[column])] = covariance(row, column);
    }
  }
  message[6 * 3 + 3] = message[6 * 4 + 4] = kTilt * kTilt;
  return message;
}

ratslam_ros::TopologicalMap mapToMessage(const ExperienceGraph& graph, const std_msgs::Header& header) {
  ratslam_ros::TopologicalMap message;
  message.header = header;
  message.node_count = static_cast<std::uint32_t>(graph.experiences().size());
  message.node.resize(graph.experiences().size());
  for (std::uint32_t id = 0; id < message.node_count; ++id) {
    message.node[id].id = id;
    message.node[id].pose = poseToMessage(graph.experiences()[id].pose);
  }
  message.edge_count = static_cast<std::uint32_t>(graph.links().size());
  message.edge.resize(graph.links().size());
  for (std::uint32_t id = 0; id < message.edge_count; ++id) {
    const Link& link = graph.links()[id];
    const double scale = graph.pose(link.from).scale();
    ratslam_ros::TopologicalEdge& edge = message.edge[id];
    edge.id = id;
    edge.source_id = link.from;
    edge.destination_id = link.to;
    edge.duration = ros::Duration(std::clamp(link.duration_s, -kLongest, kLongest));
    edge.transform.translation.x = scale * link.distance * std::cos(link.heading_rad);
    edge.transform.translation.y = scale * link.distance * std::sin(link.heading_rad);
    edge.transform.translation.z = scale * link.rise;
    edge.transform.rotation = yawToMessage(link.facing_rad);
  }
  return message;
}

visualization_msgs::Marker markerToMessage(const ExperienceGraph& graph, const std_msgs::Header& header,
                                           double line_width) {
  const std_msgs::ColorRGBA driven = colour(0.2F, 0.6F, 1.0F);
  const std_msgs::ColorRGBA recalled = colour(1.0F, 0.35F, 0.1F);
  visualization_msgs::Marker message;
  message.header = header;
  message.ns = "experience_map";
  message.type = visualization_msgs::Marker::LINE_LIST;
  const bool empty = graph.links().empty();  // rviz refuses a list of no lines
  message.action = empty ? visualization_msgs::Marker::DELETE : visualization_msgs::Marker::ADD;
  message.pose.orientation.w = 1.0;
  message.scale.x = line_width;
  message.color = driven;
  message.points.reserve(2 * graph.links().size());
  message.colors.reserve(2 * graph.links().size());
  for (const Link& link : graph.links()) {
    message.points.push_back(pointToMessage(graph.pose(link.from)));
    message.points.push_back(pointToMessage(graph.pose(link.to)));
    message.colors.insert(message.colors.end(), 2, link.recall ? recalled : driven);
  }
  return message;
}

nav_msgs::Path pathToMessage(const std::vector<MapPose>& poses, const std_msgs::Header& header) {
  nav_msgs::Path message;
  message.header = header;
  message.poses.resize(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    message.poses[i].header = header;
    message.poses[i].pose = poseToMessage(poses[i]);
  }
  return message;
}

}  // namespace ratslam
