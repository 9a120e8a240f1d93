#include "ratslam_ros/support/stream_watch.h"

#include <ros/console.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>

#include "ratslam/common/text_file.h"

namespace ratslam {
namespace {

constexpr double kPatience_s = 5.0;

std::string lastPart(const std::string& name) { return name.substr(name.rfind('/') + 1); }

/// Whether a topic has pictures drawn by the nodes, which cannot be their input.
bool isOwnPicture(const std::string& topic) {
  return endsWith(topic, "/LocalView/View") || endsWith(topic, "/PoseCell/Activity") ||
         endsWith(topic, "/ExperienceMap/Picture") || endsWith(topic, "/debug_image");
}

/// The published topics with their types; none if the master does not answer. ros::master::getTopics would wait for it,
/// for ever if it is gone.
std::optional<std::vector<ros::master::TopicInfo>> publishedTopics() {
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue payload;
  request[0] = ros::this_node::getName();
  request[1] = "";
  const bool wait_for_master = false;
  if (!ros::master::execute("getPublishedTopics", request, response, payload, wait_for_master))
    return std::nullopt;
  std::vector<ros::master::TopicInfo> topics;
  try {
    for (int i = 0; i < payload.size(); ++i) {
      topics.emplace_back(static_cast<std::string>(payload[i][0]), static_cast<std::string>(payload[i][1]));
    }
  } catch (const XmlRpc::XmlRpcException&) {  // no valid answer of the master
    return std::nullopt;
  }
  return topics;
}

/// Topics of a bag that `playback` keeps from the nodes.
bool isLeftOut(const std::string& topic) { return topic.find("/left_out/") != std::string::npos; }

/// What to do if these are the images of `topic` in another transport, or `topic` itself with another type; else empty.
std::string adviceOn(const std::string& topic, const std::string& type,
                     const ros::master::TopicInfo& published) {
  const std::string ending = "/compressed";
  const bool compressed = published.datatype == "sensor_msgs/CompressedImage";
  if (published.name == topic + ending && compressed) return "read with _image_transport:=compressed";
  if (topic == published.name + ending && published.datatype == "sensor_msgs/Image")
    return "read with _image_transport:=raw";
  const bool same_name = published.name == topic && published.datatype != type;
  if (compressed && endsWith(published.name, ending) && (same_name || topic == published.name + ending)) {
    return "its base topic is " + published.name.substr(0, published.name.size() - ending.size()) +
           ", to be read with _image_transport:=compressed";
  }
  return same_name ? "this topic has another type" : "";
}

}  // namespace

std::optional<bool> isPublished(const std::string& topic) {
  const auto published = publishedTopics();
  if (!published) return std::nullopt;
  return std::any_of(published->begin(), published->end(),
                     [&topic](const ros::master::TopicInfo& candidate) { return candidate.name == topic; });
}

std::vector<std::string> similarTopics(const std::string& topic, const std::string& type,
                                       const std::vector<ros::master::TopicInfo>& published) {
  std::vector<std::string> similar;
  for (const ros::master::TopicInfo& candidate : published) {
    const std::string advice = adviceOn(topic, type, candidate);
    if (!advice.empty()) {
      similar.insert(similar.begin(), candidate.name + " [" + candidate.datatype + "] (" + advice + ")");
      continue;
    }
    if (candidate.name == topic || isOwnPicture(candidate.name) || isLeftOut(candidate.name)) continue;
    if (candidate.datatype == type || lastPart(candidate.name) == lastPart(topic)) {
      similar.push_back(candidate.name + " [" + candidate.datatype + "]");
    }
  }
  return similar;
}

void StreamWatch::warnIfItNeverCame() {
  if (warned_ || came_ || !started_ || ros::WallTime::now() - *started_ < ros::WallDuration(kPatience_s))
    return;
  warned_ = true;
  std::string hint;
  for (const std::string& similar :
       similarTopics(topic_, type_, publishedTopics().value_or(std::vector<ros::master::TopicInfo>()))) {
    hint += (hint.empty() ? "; published are " : ", ") + similar;
  }
  ROS_WARN("nothing has come on %s [%s] for %.0f s%s", topic_.c_str(), type_.c_str(), kPatience_s,
           hint.empty() ? "; nobody publishes anything like it" : hint.c_str());
}

bool SyncTimeout::expired(bool something_waits) {
  if (!something_waits) {
    waiting_since_.reset();
    return false;
  }
  if (given_up_) return true;
  const Clocks now{ros::WallTime::now(), ros::Time::now()};
  // The waiting begins anew if the clock goes back.
  if (!waiting_since_ || now.ros < waiting_since_->ros) waiting_since_ = now;
  const double waited =
      std::min((now.wall - waiting_since_->wall).toSec(), (now.ros - waiting_since_->ros).toSec());
  given_up_ = waited >= timeout_s_;
  return given_up_;
}

}  // namespace ratslam
