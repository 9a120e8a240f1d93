/// Deserialisation of messages that checks the lengths of arrays.
///
/// ROS allocates an array of the length in the message, and only then notices that the bytes are missing: a message of
/// 60 bytes can ask for 200 GB. This stream first compares the length with the remaining bytes.
#pragma once

#include <ros/serialization.h>

#include <cstdint>
#include <vector>

namespace ratslam {

class CheckedStream : public ros::serialization::IStream {
 public:
  using IStream::IStream;

  template <class T>
  void next(T& value) {
    ros::serialization::deserialize(*this, value);
  }

  /// @throws ros::serialization::StreamOverrunException if there are fewer bytes than the elements need
  template <class T, class Allocator>
  void next(std::vector<T, Allocator>& array) {
    static const std::uint64_t least = ros::serialization::serializationLength(T());
    IStream ahead(getData(), getLength());
    std::uint32_t count = 0;
    ahead.next(count);
    if (count * least > ahead.getLength()) ros::serialization::throwStreamOverrun();
    ros::serialization::deserialize(*this, array);
  }
};

/// Reads a message from its bytes. @throws ros::serialization::StreamOverrunException if there are too few
template <class Message>
void readChecked(std::uint8_t* bytes, std::uint32_t count, Message& message) {
  std::uint8_t none = 0;  // ROS needs the address of a first byte even for an empty message
  CheckedStream stream(count > 0 ? bytes : &none, count);
  stream.next(message);
}

}  // namespace ratslam
