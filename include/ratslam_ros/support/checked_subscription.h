/// Subscriptions whose messages are deserialised by a CheckedStream.
#pragma once

#include <ros/node_handle.h>

#include <boost/make_shared.hpp>
#include <functional>
#include <string>

#include "ratslam_ros/support/checked_stream.h"

namespace ratslam {

/// Callback helper that roscpp calls for each message.
template <class Message>
class CheckedCallback : public ros::SubscriptionCallbackHelperT<const ros::MessageEvent<const Message>&> {
 public:
  using Base = ros::SubscriptionCallbackHelperT<const ros::MessageEvent<const Message>&>;
  /// Receives the reason why a message could not be read.
  using Refused = std::function<void(const std::string& why)>;

  CheckedCallback(const typename Base::Callback& callback, Refused refused)
      : Base(callback), refused_(std::move(refused)) {}

  /// @return null if the message is refused; roscpp then continues with the next one
  ros::VoidConstPtr deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& bytes) override {
    const auto message = boost::make_shared<Message>();
    try {
      readChecked(bytes.buffer, bytes.length, *message);
      return message;
    } catch (const ros::serialization::StreamOverrunException&) {
      refused_("the lengths that it names do not fit into its " + std::to_string(bytes.length) + " bytes");
      return {};
    }
  }

 private:
  Refused refused_;
};

/// @param handler  receives an event for each message
/// @param refused  receives the reason for each message that is left out
template <class Message>
ros::Subscriber subscribeChecked(
    ros::NodeHandle& handle, const std::string& topic, std::uint32_t queue_size,
    const boost::function<void(const ros::MessageEvent<const Message>&)>& handler,
    typename CheckedCallback<Message>::Refused refused) {
  ros::SubscribeOptions options;
  options.topic = topic;
  options.queue_size = queue_size;
  options.md5sum = ros::message_traits::md5sum<Message>();
  options.datatype = ros::message_traits::datatype<Message>();
  options.helper = boost::make_shared<CheckedCallback<Message>>(handler, std::move(refused));
  return handle.subscribe(options);
}

}  // namespace ratslam
