// The messages OpenRatSLAM's bags carry: one field moved or renamed and those bags no longer play into the
// nodes.
#include <gtest/gtest.h>
#include <ros/message_traits.h>

#include "ratslam_ros/TopologicalAction.h"
#include "ratslam_ros/TopologicalEdge.h"
#include "ratslam_ros/TopologicalMap.h"
#include "ratslam_ros/TopologicalNode.h"
#include "ratslam_ros/ViewTemplate.h"

namespace {

template <class Message>
std::string md5() {
  return ros::message_traits::MD5Sum<Message>::value();
}

TEST(MessageMd5, EqualsOpenRatSlam) {
  EXPECT_EQ(md5<ratslam_ros::ViewTemplate>(), "a3978e682f73dc18ef3727352b92d92e");
  EXPECT_EQ(md5<ratslam_ros::TopologicalAction>(), "365d6e23e0fb90a477e21472cd2edf80");
  EXPECT_EQ(md5<ratslam_ros::TopologicalNode>(), "9ad7ea65113411e05ab5cf09fc962a2d");
  EXPECT_EQ(md5<ratslam_ros::TopologicalEdge>(), "c5998f5af8b3f0379746951076b5511a");
  EXPECT_EQ(md5<ratslam_ros::TopologicalMap>(), "deefb2c5a22caaa16af4e1b64a821bdc");
}

TEST(MessageMd5, ActionNumbersAreTheWireFormat) {
  EXPECT_EQ(ratslam_ros::TopologicalAction::CREATE_NODE + 0U, 1U);
  EXPECT_EQ(ratslam_ros::TopologicalAction::CREATE_EDGE + 0U, 2U);
  EXPECT_EQ(ratslam_ros::TopologicalAction::SET_NODE + 0U, 3U);
}

}  // namespace
