/// Checks the lengths and positions in a bag's records before rosbag uses them. rosbag does not check them: it allocates
/// any length and reads at any position that an index names.
///
/// The file is read once, when it is opened. Compressed chunks are checked later, one by one, each before its first
/// message is read, because they must be unpacked for it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ratslam/common/stamp.h"

namespace ratslam {

class BagCheck {
 public:
  /// A compressed chunk that has not been checked.
  struct PackedChunk {
    std::uint64_t at = 0;    ///< byte of the file at which its record begins
    std::uint64_t data = 0;  ///< byte at which its packed data begin, `length` bytes
    std::uint64_t length = 0;
    std::uint64_t unpacked = 0;           ///< unpacked size by its header [bytes]
    std::string compression;              ///< bz2 or lz4
    Stamp first = 0;                      ///< time of recording of its first message, by the index
    std::vector<std::uint32_t> messages;  ///< position of each message in the unpacked data, by the index
  };

  /// Checks that records follow each other within the file, that indexes point at messages within their chunk, and that
  /// no chunk claims to unpack to far more than its size.
  /// @throws std::runtime_error naming the file and the byte at which it is damaged
  explicit BagCheck(const std::string& path);

  /// Checks the compressed chunks whose messages begin up to this time, each once.
  /// @throws std::runtime_error naming the file and the byte of a chunk that does not unpack to the size in its header,
  /// or has no message at a position of the index
  void beforeReading(Stamp recorded);

 private:
  std::string path_;
  std::vector<PackedChunk> packed_;  ///< in reverse order: the next one is last
};

}  // namespace ratslam
