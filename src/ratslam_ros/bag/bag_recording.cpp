#include "ratslam_ros/bag/bag_recording.h"

#include <rosbag/exceptions.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <vector>

#include "ratslam_ros/support/camera_info.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/image_decoding.h"

namespace ratslam {
namespace {

const char kImage[] = "sensor_msgs/Image";
const char kCompressedImage[] = "sensor_msgs/CompressedImage";
const char kOdometry[] = "nav_msgs/Odometry";

using TopicTypes = std::map<std::string, std::string>;

void open(rosbag::Bag& bag, const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) throw std::runtime_error(path + ": cannot open this bag: " + error.message());
  if (size == 0) throw std::runtime_error(path + ": the file is empty, it is no bag");
  try {
    bag.open(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw std::runtime_error(
        path + ": the bag has no index (its recording was cut off); run: rosbag reindex " + path);
  } catch (const rosbag::BagException& e) {
    throw std::runtime_error(path + ": not a readable bag, or a truncated one: " + e.what());
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
  std::string list;
  for (const auto& [topic, type] : types) list += (list.empty() ? "" : ", ") + topic + " [" + type + "]";
  return list.empty() ? "no messages at all" : list;
}

/// The wanted topic if it is there, or, where none is named, the only one that will do.
std::string choose(const std::string& path, const TopicTypes& types, const std::string& wanted,
                   const char* what, const std::vector<std::string>& suitable_types,
                   const std::string& ending) {
  const auto suits = [&](const std::string& topic, const std::string& type) {
    const bool ends = topic.size() >= ending.size() &&
                      topic.compare(topic.size() - ending.size(), ending.size(), ending) == 0;
    return ends && std::find(suitable_types.begin(), suitable_types.end(), type) != suitable_types.end();
  };
  if (!wanted.empty()) {
    std::string name = wanted.front() == '/' ? wanted : "/" + wanted;
    const auto found = types.find(name);
    if (found == types.end())
      throw std::runtime_error(path + ": no topic " + name + "; the bag has " + listing(types));
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

template <class Message>
RecordedImage imageIn(const rosbag::MessageInstance& instance, const ImageLimits& limits) {
  const auto message = instance.instantiate<Message>();
  return recordedImage(message, instance.getTopic(), stampFromRos(message->header.stamp), limits);
}

}  // namespace

BagRecording::BagRecording(const std::string& path, const BagTopics& topics, const ImageLimits& limits)
    : path_(path), topics_(topics), limits_(limits) {
  open(bag_, path);
  const TopicTypes types = typesOf(bag_);
  topics_.images = choose(path, types, topics.images, "images", {kImage, kCompressedImage}, "");
  std::vector<std::string> read{topics_.images};
  if (topics.with_odometry) {
    topics_.odometry = choose(path, types, topics.odometry, "odometry", {kOdometry}, "odom");
    read.push_back(topics_.odometry);
  }
  view_ = std::make_unique<rosbag::View>(bag_, rosbag::TopicQuery(read));
  position_ = view_->begin();
  image_count_ = rosbag::View(bag_, rosbag::TopicQuery(topics_.images)).size();
}

std::optional<CameraModel> BagRecording::camera() const {
  std::string beside = topics_.images;
  const std::string compressed = "/compressed";
  if (beside.size() > compressed.size() &&
      beside.compare(beside.size() - compressed.size(), compressed.size(), compressed) == 0) {
    beside.erase(beside.size() - compressed.size());
  }
  beside.erase(beside.find_last_of('/') + 1);
  rosbag::View view(bag_, rosbag::TopicQuery(beside + "camera_info"));
  for (const rosbag::MessageInstance& instance : view) {
    const auto message = instance.instantiate<sensor_msgs::CameraInfo>();
    if (message) return cameraFromMessage(*message);
  }
  return std::nullopt;
}

std::optional<RecordedItem> BagRecording::next() {
  try {
    if (position_ == view_->end()) return std::nullopt;
    const rosbag::MessageInstance instance = *position_;
    ++position_;
    const std::string& type = instance.getDataType();
    if (type == kOdometry) return odometryFromMessage(*instance.instantiate<nav_msgs::Odometry>());
    if (type == kImage) return imageIn<sensor_msgs::Image>(instance, limits_);
    return imageIn<sensor_msgs::CompressedImage>(instance, limits_);
  } catch (const rosbag::BagException& e) {
    throw std::runtime_error(path_ + ": the bag cannot be read any further: " + e.what());
  }
}

}  // namespace ratslam
