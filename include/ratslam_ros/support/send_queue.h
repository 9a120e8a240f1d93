/// How far a subscriber may lag behind one of our publishers, and how it learns that it lagged too far.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace ratslam {

/// Messages of the chain that wait for a subscriber which does not read: 16 minutes at 20 Hz. Beyond, the oldest go: a
/// subscriber that is stopped for days must not take the memory of the machine.
constexpr std::uint32_t kSendQueue = 20'000;

/// Tells from the numbers that ROS gives the messages of a publisher how many of them never came.
class LossWatch {
 public:
  /// To be called for every message. @param number  header.seq   @return messages lost before this one
  std::size_t messageOf(const std::string& publisher, std::uint32_t number) {
    const auto [known, first] = last_.emplace(publisher, number);
    const std::uint32_t last = known->second;
    known->second = number;
    // A publisher that starts again counts from the beginning; within a process nobody counts.
    return first || number <= last ? 0 : number - last - 1;
  }

 private:
  std::map<std::string, std::uint32_t> last_;
};

}  // namespace ratslam
