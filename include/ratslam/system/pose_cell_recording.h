/// The pose cells' activity at every so many views, as an .npz file that numpy.load opens: `stamps`, int64 (snapshots,)
/// in nanoseconds, and `activity`, float32 (snapshots, headings, rows, columns).
///
/// Activity is mostly zeros and is compressed as it comes, so that a long drive takes little memory.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <vector>

#include "ratslam/common/stamp.h"
#include "ratslam/pose_cells/activity_grid.h"

namespace ratslam {

/// Raw deflate of bytes as they come, with what a zip file has to know of them.
class Deflater {
 public:
  Deflater();
  ~Deflater();
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  void add(const void* data, std::size_t size);
  /// Ends the stream. @return its compressed bytes
  const std::vector<std::uint8_t>& finish();
  std::uint32_t crc() const { return crc_; }
  std::uint64_t size() const { return size_; }

 private:
  struct Stream;
  void run(int flush);

  std::unique_ptr<Stream> stream_;
  std::vector<std::uint8_t> bytes_;
  std::uint32_t crc_ = 0;
  std::uint64_t size_ = 0;
  bool finished_ = false;
};

class PoseCellRecording {
 public:
  /// @param every  views from one snapshot to the next, at least 1
  explicit PoseCellRecording(std::size_t every) : every_(every) {}

  /// The activity after a view event; the first is always kept.
  void add(Stamp stamp, const ActivityGrid& activity);
  std::size_t size() const { return stamps_.size(); }

  /// @throws std::runtime_error where the file would pass 4 GB
  void write(std::ostream& file);

 private:
  std::size_t every_;
  std::size_t views_ = 0;
  std::vector<Stamp> stamps_;
  std::vector<int> shape_;  ///< of one snapshot
  Deflater activity_;
};

}  // namespace ratslam
