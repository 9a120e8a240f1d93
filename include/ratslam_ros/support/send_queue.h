/// Size of our publishers' queues, and detection of messages that were dropped there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace ratslam {

/// Most messages that wait for a subscriber which does not read: 16 minutes at 20 Hz. Beyond that the oldest are dropped:
/// a subscriber that is stopped for days must not use up the memory of the machine.
constexpr std::uint32_t kSendQueue = 20'000;

/// Counts lost messages by the numbers that ROS gives the messages of a publisher.
class LossWatch {
 public:
  /// To be called for every message. @param number  header.seq   @return messages lost before this one
  std::size_t messageOf(const std::string& publisher, std::uint32_t number) {
    const auto [known, first] = last_.emplace(publisher, number);
    const std::uint32_t last = known->second;
    known->second = number;
    // A restarted publisher counts from the beginning again. Within a process messages are not numbered.
    return first || number <= last ? 0 : number - last - 1;
  }

 private:
  std::map<std::string, std::uint32_t> last_;
};

}  // namespace ratslam
