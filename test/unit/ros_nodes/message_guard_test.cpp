#include "ratslam_ros/support/message_guard.h"

#include <gtest/gtest.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>

#include <cstring>
#include <limits>
#include <stdexcept>

#include "ratslam_ros/support/checked_subscription.h"
#include "ratslam_ros/support/conversions.h"

namespace ratslam {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(MessageGuard, CountsWhatWasDroppedByTopicAndGoesOn) {
  MessageGuard guard;
  int processed = 0;
  for (int i = 0; i < 5; ++i) {
    guard.run("/odom", [&] {
      if (i % 2 == 0) throw std::runtime_error("not this one");
      ++processed;
    });
  }
  EXPECT_TRUE(guard.run("/view", [] {}));
  EXPECT_EQ(processed, 2);
  EXPECT_EQ(guard.dropped("/odom"), 3U);
  EXPECT_EQ(guard.dropped("/view"), 0U);
}

TEST(MessageGuard, CountsWhatNeverCameByTheNumbersOfEachPublisher) {
  MessageGuard guard;
  guard.number("/view", "/lv", 7);  // whatever went before it joined
  guard.number("/view", "/lv", 8);
  EXPECT_EQ(guard.lost("/view"), 0U);
  guard.number("/view", "/lv", 20);
  guard.number("/view", "/other", 500);
  guard.number("/view", "/lv", 21);
  EXPECT_EQ(guard.lost("/view"), 11U);
  guard.number("/view", "/lv", 0);  // it was started again
  guard.number("/view", "/lv", 1);
  guard.number("/odom", "/nodelet", 0);  // within a process nobody counts
  guard.number("/odom", "/nodelet", 0);
  EXPECT_EQ(guard.lost("/view"), 11U);
  EXPECT_EQ(guard.lost("/odom"), 0U);
}

template <class Message>
std::vector<std::uint8_t> bytesOf(const Message& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

/// The message's bytes, in which the four of a length, `from_end` before the end, claim so many elements.
template <class Message>
std::vector<std::uint8_t> claiming(const Message& message, std::size_t from_end, std::uint32_t count) {
  std::vector<std::uint8_t> bytes = bytesOf(message);
  std::memcpy(&bytes.at(bytes.size() - from_end), &count, sizeof count);
  return bytes;
}

/// Gives the bytes to a subscription. @return what it hands on; null with what it says of bytes that it refuses
template <class Message>
boost::shared_ptr<const Message> taken(std::vector<std::uint8_t> bytes, std::string* said = nullptr) {
  const ros::SubscriptionCallbackHelperPtr callback =
      boost::make_shared<CheckedCallback<Message>>([](const ros::MessageEvent<const Message>&) {},
                                                   [said](const std::string& why) {
                                                     ASSERT_NE(said, nullptr);
                                                     *said += why;
                                                   });
  ros::SubscriptionCallbackHelperDeserializeParams params;
  params.buffer = bytes.data();
  params.length = static_cast<std::uint32_t>(bytes.size());
  return boost::static_pointer_cast<const Message>(callback->deserialize(params));
}

TEST(CheckedSubscription, HandsOnWhatWasSent) {
  sensor_msgs::Image image;
  image.header.frame_id = "camera";
  image.encoding = "mono8";
  image.data = {1, 2, 3};
  const auto taken_image = taken<sensor_msgs::Image>(bytesOf(image));
  ASSERT_TRUE(taken_image);
  EXPECT_EQ(bytesOf(*taken_image), bytesOf(image));  // older messages have no ==
  ratslam_ros::OdometryQuality quality;
  quality.correction_way_stamps = {ros::Time(3, 4)};
  quality.correction_way.resize(1);
  quality.correction_way[0].position.y = 2.5;
  EXPECT_EQ(bytesOf(*taken<ratslam_ros::OdometryQuality>(bytesOf(quality))), bytesOf(quality));
}

TEST(CheckedSubscription, MakesNoArrayForWhichThereAreNoBytes) {
  // As much as would take the machine's memory, and as much as wraps at 32 bits.
  for (const std::uint32_t count : {0xFFFFFFF0U, 0x20000001U, 4U}) {
    std::string said;
    sensor_msgs::Image image;
    image.data = {1, 2, 3};
    EXPECT_FALSE(taken<sensor_msgs::Image>(claiming(image, 7, count), &said));
    EXPECT_NE(said.find("do not fit into its " + std::to_string(bytesOf(image).size()) + " bytes"),
              std::string::npos);
    ratslam_ros::OdometryQuality quality;
    EXPECT_FALSE(taken<ratslam_ros::OdometryQuality>(claiming(quality, 4, count), &said));
    sensor_msgs::CameraInfo info;
    info.D = {0.0};
    const std::size_t behind_d =
        8 + 8 * (9 + 9 + 12) + 4 + 4 + 17;  // D itself, K, R, P, binning, region of interest
    EXPECT_EQ(taken<sensor_msgs::CameraInfo>(claiming(info, behind_d + 4, 1))->D, info.D);
    EXPECT_FALSE(taken<sensor_msgs::CameraInfo>(claiming(info, behind_d + 4, count + 1000), &said));
    // Elements whose own lengths are of several bytes.
    EXPECT_FALSE(taken<tf2_msgs::TFMessage>(claiming(tf2_msgs::TFMessage(), 4, count), &said));
  }
  std::string said;
  EXPECT_FALSE(taken<sensor_msgs::Image>({}, &said));
}

TEST(Conversions, OnlyWhatCanChangeInADriveIsAChange) {
  ratslam_ros::ParameterChange change;
  change.header.stamp = ros::Time(3, 4);
  change.name = "vt_match_threshold";
  change.value = "0.05";
  EXPECT_EQ(changeFromMessage(change).after, 3000000004);
  for (const char* value : {"", "0.05\n9,exp_loops,1", "nan", "much"}) {
    change.value = value;
    EXPECT_THROW(changeFromMessage(change), std::runtime_error) << value;
  }
  change.value = "1";
  change.name = "pc_dim_xy";
  EXPECT_THROW(changeFromMessage(change), std::runtime_error);
}

TEST(Conversions, NumbersThatAreNotFiniteAreRefused) {
  ratslam_ros::ViewTemplate view;
  view.relative_rad = kNaN;
  EXPECT_THROW(viewFromMessage(view), std::runtime_error);
  ratslam_ros::TopologicalAction action;
  action.action = 1;
  action.relative_rad = std::numeric_limits<double>::infinity();
  EXPECT_THROW(actionFromMessage(action), std::runtime_error);
  ratslam_ros::RecallGeometry geometry;
  geometry.distance = kNaN;
  EXPECT_NO_THROW(geometryFromMessage(geometry)) << "nothing was measured";
  geometry.inliers = 30;
  EXPECT_THROW(geometryFromMessage(geometry), std::runtime_error);
}

}  // namespace
}  // namespace ratslam
