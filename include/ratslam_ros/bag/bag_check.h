/// Looks at the lengths and places in a bag's records before rosbag does, which believes them: it allocates what
/// a length says and reads where an index points.
///
/// The file is gone through once, when it is opened. What a compressed chunk holds can be seen only once it is unpacked:
/// that is done when a message of it is about to be read, chunk by chunk, as rosbag does it afterwards.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ratslam/common/stamp.h"

namespace ratslam {

class BagCheck {
 public:
  /// A compressed chunk that has not been looked into.
  struct PackedChunk {
    std::uint64_t at = 0;    ///< byte of the file at which its record begins
    std::uint64_t data = 0;  ///< byte at which what is packed begins, `length` bytes
    std::uint64_t length = 0;
    std::uint64_t unpacked = 0;           ///< bytes that its header says it unpacks to
    std::string compression;              ///< bz2 or lz4
    Stamp first = 0;                      ///< when its first message was recorded, as the index says
    std::vector<std::uint32_t> messages;  ///< where they begin once it is unpacked, as the index says
  };

  /// Records lie one behind the other within the file, indexes point at messages within their chunk, and no chunk
  /// claims to unpack to far more than it is.
  /// @throws std::runtime_error naming the file and the byte at which it is damaged
  explicit BagCheck(const std::string& path);

  /// Looks into the compressed chunks whose messages begin up to this time, each once.
  /// @throws std::runtime_error naming the file and the byte of a chunk that does not unpack to what its header says, or
  /// in which no message lies where the index says so
  void beforeReading(Stamp recorded);

 private:
  std::string path_;
  std::vector<PackedChunk> packed_;  ///< the next one last
};

}  // namespace ratslam
