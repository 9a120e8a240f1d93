#include "ratslam_ros/bag/bag_recording.h"

#include <rosbag/exceptions.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <vector>

#include "ratslam/common/text_file.h"
#include "ratslam_ros/support/camera_info.h"
#include "ratslam_ros/support/checked_stream.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/image_decoding.h"

namespace ratslam {
namespace {

const char kImage[] = "sensor_msgs/Image";
const char kCompressedImage[] = "sensor_msgs/CompressedImage";
const char kOdometry[] = "nav_msgs/Odometry";

using TopicTypes = std::map<std::string, std::string>;

BagCheck open(rosbag::Bag& bag, const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    throw std::runtime_error(path + ": cannot open this bag: no such file or folder");
  }
  if (status.type() != fs::file_type::regular) {
    throw std::runtime_error(path + ": cannot open this bag: it is no regular file (a pipe or a device)");
  }
  const auto size = fs::file_size(path, error);
  if (error) throw std::runtime_error(path + ": cannot open this bag: " + error.message());
  if (size == 0) throw std::runtime_error(path + ": the file is empty, it is no bag");
  BagCheck check(path);
  try {
    bag.open(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw std::runtime_error(
        path + ": the bag has no index (its recording was cut off); run: rosbag reindex " + path);
  } catch (const std::exception& e) {  // rosbag throws various exceptions for a damaged file
    throw std::runtime_error(path + ": not a readable bag, or a truncated one: " + e.what());
  }
  return check;
}

/// Refuses messages of another definition than ours, even if their type has the same name.
template <class Message>
void requireDefinition(const rosbag::Bag& bag, const std::string& path, const std::string& topic) {
  const std::string ours = ros::message_traits::MD5Sum<Message>::value();
  rosbag::View view(bag, rosbag::TopicQuery(topic));
  for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
    const bool same_type = connection->datatype == ros::message_traits::DataType<Message>::value();
    if (!same_type || connection->md5sum == ours || connection->md5sum == "*") continue;
    throw std::runtime_error(path + ": " + shown(topic) + " is " + connection->datatype +
                             " of another definition: md5 sum " + shown(connection->md5sum) + ", here " +
                             ours + "; rosbag check and fix can translate it");
  }
}

TopicTypes typesOf(const rosbag::Bag& bag) {
  rosbag::View all(bag);
  TopicTypes types;
  for (const rosbag::ConnectionInfo* connection : all.getConnections())
    types[connection->topic] = connection->datatype;
  return types;
}

std::string listing(const TopicTypes& types) {
  constexpr std::size_t kMost = 40;
  std::string list;
  std::size_t count = 0;
  for (const auto& [topic, type] : types) {
    if (++count > kMost) return list + " and " + std::to_string(types.size() - kMost) + " more";
    list += (list.empty() ? "" : ", ") + shown(topic) + " [" + shown(type) + "]";
  }
  return list.empty() ? "no messages at all" : list;
}

/// The wanted topic, or, if none is named, the only suitable one.
std::string choose(const std::string& path, const TopicTypes& types, const std::string& wanted,
                   const char* what, const std::vector<std::string>& suitable_types,
                   const std::string& ending) {
  const auto suits = [&](const std::string& topic, const std::string& type) {
    return endsWith(topic, ending) &&
           std::find(suitable_types.begin(), suitable_types.end(), type) != suitable_types.end();
  };
  if (!wanted.empty()) {
    std::string name = wanted.front() == '/' ? wanted : "/" + wanted;
    const auto found = types.find(name);
    if (found == types.end())
      throw std::runtime_error(path + ": no topic " + shown(name) + "; the bag has " + listing(types));
    if (!suits(found->first + ending, found->second)) {
      throw std::runtime_error(path + ": " + name + " is " + found->second + ", not " + what);
    }
    return name;
  }
  std::string chosen;
  for (const auto& [topic, type] : types) {
    if (!suits(topic, type)) continue;
    if (!chosen.empty()) {
      throw std::runtime_error(path + ": more than one topic of " + what +
                               ", name one of them; the bag has " + listing(types));
    }
    chosen = topic;
  }
  if (chosen.empty())
    throw std::runtime_error(path + ": no topic of " + what + "; the bag has " + listing(types));
  return chosen;
}

/// The message; none if its bytes are no message of its type.
template <class Message>
boost::shared_ptr<Message> messageIn(BagCheck& check, const rosbag::MessageInstance& instance) {
  check.beforeReading(stampFromRos(instance.getTime()));
  if (!instance.isType<Message>()) return nullptr;
  std::vector<std::uint8_t> bytes(instance.size());
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  instance.write(stream);
  try {
    auto message = boost::make_shared<Message>();
    readChecked(bytes.data(), static_cast<std::uint32_t>(bytes.size()), *message);
    return message;
  } catch (const ros::serialization::StreamOverrunException&) {
    return nullptr;
  }
}

template <class Message>
RecordedImage imageIn(BagCheck& check, const rosbag::MessageInstance& instance, const ImageLimits& limits) {
  const auto message = messageIn<Message>(check, instance);
  if (!message) {
    RecordedImage none;
    none.stamp = stampFromRos(instance.getTime());
    none.name = instance.getTopic() + " recorded at " + std::to_string(instance.getTime().toSec());
    none.decode = []() -> cv::Mat { throw BadImage("damaged message: its lengths do not fit its size"); };
    return none;
  }
  const boost::shared_ptr<const Message> held = message;
  return recordedImage(held, instance.getTopic(), stampFromRos(held->header.stamp), limits);
}

}  // namespace

BagRecording::BagRecording(const std::string& path, const BagTopics& topics, const ImageLimits& limits)
    : path_(path), topics_(topics), limits_(limits), check_(open(bag_, path)) {
  const TopicTypes types = typesOf(bag_);
  topics_.images = choose(path, types, topics.images, "images", {kImage, kCompressedImage}, "");
  std::vector<std::string> read{topics_.images};
  if (topics.with_odometry) {
    topics_.odometry = choose(path, types, topics.odometry, "odometry", {kOdometry}, "odom");
    read.push_back(topics_.odometry);
  }
  requireDefinition<sensor_msgs::Image>(bag_, path, topics_.images);
  requireDefinition<sensor_msgs::CompressedImage>(bag_, path, topics_.images);
  if (topics.with_odometry) {
    requireDefinition<nav_msgs::Odometry>(bag_, path, topics_.odometry);
    beginPairing();
  }
  view_ = std::make_unique<rosbag::View>(bag_, rosbag::TopicQuery(read));
  position_ = view_->begin();
  image_count_ = rosbag::View(bag_, rosbag::TopicQuery(topics_.images)).size();
}

void BagRecording::beginPairing() {
  const std::string topic = topics_.odometry + "_quality";
  requireDefinition<ratslam_ros::OdometryQuality>(bag_, path_, topic);
  if (rosbag::View(bag_, rosbag::TopicQuery(topic)).size() == 0) return;
  const std::vector<std::string> both{topics_.odometry, topic};
  paired_view_ = std::make_unique<rosbag::View>(bag_, rosbag::TopicQuery(both));
  paired_position_ = paired_view_->begin();
}

std::optional<OdometrySample> BagRecording::nextPaired() {
  std::optional<OdometrySample> sample = pairing_.next(true);
  for (; !sample && paired_position_ != paired_view_->end(); sample = pairing_.next(true)) {
    hear(*paired_position_);
    ++paired_position_;
  }
  return sample ? sample : pairing_.next(false);
}

void BagRecording::hear(const rosbag::MessageInstance& instance) {
  if (instance.getTopic() == topics_.odometry) {
    const auto odometry = messageIn<nav_msgs::Odometry>(check_, instance);
    if (odometry) pairing_.hearSample(odometryFromMessage(*odometry));
    return;
  }
  const auto quality = messageIn<ratslam_ros::OdometryQuality>(check_, instance);
  if (!quality) return;
  try {
    requireUsable(*quality);
    pairing_.hearQuality(*quality);
  } catch (const std::runtime_error&) {  // as in the nodes the sample is then used without it
  }
}

std::optional<CameraModel> BagRecording::camera() const {
  std::string beside = withoutCompressed(topics_.images);
  beside.erase(beside.find_last_of('/') + 1);
  const std::string topic = beside + "camera_info";
  requireDefinition<sensor_msgs::CameraInfo>(bag_, path_, topic);
  rosbag::View view(bag_, rosbag::TopicQuery(topic));
  std::string reason;
  const std::vector<cv::Size> sizes = view.size() > 0 ? firstImageSizes() : std::vector<cv::Size>();
  for (const rosbag::MessageInstance& instance : view) {
    const auto message = messageIn<sensor_msgs::CameraInfo>(check_, instance);
    if (!message) continue;
    for (const cv::Size& size : sizes) {
      try {
        return cameraFromMessage(*message, isRectifiedTopic(topics_.images), size);
      } catch (const std::invalid_argument& e) {
        if (reason.empty()) reason = e.what();
      }
    }
  }
  if (view.size() == 0) return std::nullopt;
  throw std::runtime_error(path_ + ": " + topic + " holds no usable calibration: " +
                           (reason.empty() ? "its messages are damaged or of another type" : reason));
}

std::vector<cv::Size> BagRecording::firstImageSizes() const {
  constexpr std::size_t kLookedAt = 10;  // more than one, because the first image may have an odd size
  rosbag::View view(bag_, rosbag::TopicQuery(topics_.images));
  std::vector<cv::Size> sizes;
  for (const rosbag::MessageInstance& instance : view) {
    if (sizes.size() == kLookedAt) break;
    const bool raw = instance.getDataType() == kImage;
    const RecordedImage image = raw ? imageIn<sensor_msgs::Image>(check_, instance, limits_)
                                    : imageIn<sensor_msgs::CompressedImage>(check_, instance, limits_);
    const cv::Size size = decodeNow(image).image.size();
    if (!size.empty()) sizes.push_back(size);  // a corrupt image has no size
  }
  if (sizes.empty()) return {cv::Size()};
  const auto count = [all = sizes](const cv::Size& size) { return std::count(all.begin(), all.end(), size); };
  std::stable_sort(sizes.begin(), sizes.end(),
                   [&](const cv::Size& a, const cv::Size& b) { return count(a) > count(b); });
  return sizes;
}

std::optional<RecordedItem> BagRecording::next() {
  try {
    while (position_ != view_->end()) {
      const rosbag::MessageInstance instance = *position_;
      ++position_;
      const std::string& type = instance.getDataType();
      if (type == kImage) return imageIn<sensor_msgs::Image>(check_, instance, limits_);
      if (type == kCompressedImage) return imageIn<sensor_msgs::CompressedImage>(check_, instance, limits_);
      const auto odometry = messageIn<nav_msgs::Odometry>(check_, instance);
      if (!odometry) continue;
      if (!paired_view_) return odometryFromMessage(*odometry);
      if (const auto sample = nextPaired()) return *sample;
    }
    return std::nullopt;
  } catch (const ros::Exception& e) {  // base of the exceptions of rosbag and of its parts
    throw std::runtime_error(path_ + ": the bag cannot be read any further: " + e.what());
  }
}

}  // namespace ratslam
