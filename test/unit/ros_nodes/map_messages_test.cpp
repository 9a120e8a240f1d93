#include "ratslam_ros/support/map_messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "ratslam_ros/support/trajectory_files.h"

namespace ratslam {
namespace {

ExperienceGraph twoPlaces() {
  ExperienceGraph graph;
  graph.addExperience({1.0, 2.0, 0.5, 0.3, std::log(2.0)});
  graph.addExperience({5.0, 6.0, 0.7, -2.0});
  Link link;
  link.from = 0;
  link.to = 1;
  link.distance = 3.0;
  link.heading_rad = 0.4;
  link.facing_rad = -0.6;
  link.rise = 0.1;
  link.duration_s = 1.5;
  graph.addLink(link);
  link.from = 1;
  link.to = 0;
  link.recall = true;
  graph.addLink(link);
  return graph;
}

std_msgs::Header mapHeader() {
  std_msgs::Header header;
  header.frame_id = "map";
  header.stamp = ros::Time(12, 34);
  return header;
}

TEST(MapMessage, TakesLinksOverAnyTime) {
  ExperienceGraph graph = twoPlaces();
  Link link;
  link.to = 1;
  link.duration_s = 4.2e9;  // a clock that was set from 1970 to 2103
  graph.addLink(link);
  EXPECT_EQ(mapToMessage(graph, mapHeader()).edge.back().duration, ros::Duration(2147483647.0));
}

TEST(MapMessage, HoldsPlacesAndWhatLinksMeasured) {
  const ratslam_ros::TopologicalMap message = mapToMessage(twoPlaces(), mapHeader());
  EXPECT_EQ(message.header.stamp, ros::Time(12, 34));
  ASSERT_EQ(message.node_count, 2U);
  ASSERT_EQ(message.node.size(), 2U);
  EXPECT_EQ(message.node[1].id, 1U);
  EXPECT_EQ(message.node[1].pose.position.z, 0.7);
  EXPECT_NEAR(2.0 * std::atan2(message.node[1].pose.orientation.z, message.node[1].pose.orientation.w), -2.0,
              1e-12);
  ASSERT_EQ(message.edge_count, 2U);
  ASSERT_EQ(message.edge.size(), 2U);
  const ratslam_ros::TopologicalEdge& edge = message.edge[0];
  EXPECT_EQ(edge.source_id, 0U);
  EXPECT_EQ(edge.destination_id, 1U);
  EXPECT_EQ(edge.duration, ros::Duration(1.5));
  // Three units of an odometry whose unit is two metres there.
  EXPECT_NEAR(std::hypot(edge.transform.translation.x, edge.transform.translation.y), 6.0, 1e-12);
  EXPECT_NEAR(std::atan2(edge.transform.translation.y, edge.transform.translation.x), 0.4, 1e-12);
  EXPECT_NEAR(edge.transform.translation.z, 0.2, 1e-12);
  EXPECT_NEAR(2.0 * std::atan2(edge.transform.rotation.z, edge.transform.rotation.w), -0.6, 1e-12);
}

TEST(MarkerMessage, DrawsEveryLinkBetweenItsPlacesAndTellsRecallsApart) {
  const visualization_msgs::Marker marker = markerToMessage(twoPlaces(), mapHeader(), 0.2);
  EXPECT_EQ(marker.type, visualization_msgs::Marker::LINE_LIST);
  ASSERT_EQ(marker.points.size(), 4U);
  ASSERT_EQ(marker.colors.size(), 4U);
  EXPECT_EQ(marker.points[0].x, 1.0);
  EXPECT_EQ(marker.points[1].x, 5.0);
  EXPECT_EQ(marker.points[2].x, 5.0);
  EXPECT_EQ(marker.points[3].x, 1.0);
  // Messages of older ROS distributions cannot be compared.
  const auto& driven = marker.colors[0];
  const auto& recalled = marker.colors[2];
  EXPECT_NE(std::tie(driven.r, driven.g, driven.b), std::tie(recalled.r, recalled.g, recalled.b));
  const double norm = marker.pose.orientation.w;  // rviz drops markers without a proper orientation
  EXPECT_EQ(norm, 1.0);
}

TEST(TrajectoryFileNames, TellOnlineAndFinalApart) {
  EXPECT_EQ(trajectoryFiles("runs/kitti", "tum").online, "runs/kitti_online.tum");
  EXPECT_EQ(trajectoryFiles("runs/kitti.tum", "tum").final, "runs/kitti_final.tum");
  EXPECT_EQ(trajectoryFiles("runs/kitti.txt", "kitti").final, "runs/kitti_final.txt");
  EXPECT_EQ(trajectoryFiles("runs/v1.2", "tum").final, "runs/v1.2_final.tum");
}

}  // namespace
}  // namespace ratslam
