/// Takes messages apart without believing the lengths that they name.
///
/// ROS makes an array as long as its message says, and only then finds out that the bytes are not there: a message of
/// 60 bytes may ask for 200 GB. Here the bytes are counted first.
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

  /// @throws ros::serialization::StreamOverrunException where there are fewer bytes than so many elements take
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

/// Reads a message from its bytes. @throws ros::serialization::StreamOverrunException where they are too few
template <class Message>
void readChecked(std::uint8_t* bytes, std::uint32_t count, Message& message) {
  std::uint8_t none = 0;  // ROS counts from the first byte on also where there is none
  CheckedStream stream(count > 0 ? bytes : &none, count);
  stream.next(message);
}

}  // namespace ratslam
