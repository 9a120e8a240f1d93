/// Snapshots of the pose cells' activity at regular numbers of views, as an .npz file for numpy.load: `stamps`,
/// int64 (snapshots,) in nanoseconds, and `activity`, float32 (snapshots, headings, rows, columns).
///
/// Activity is mostly zeros. It is compressed immediately, so that a long drive needs little memory.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <vector>

#include "ratslam/common/stamp.h"
#include "ratslam/pose_cells/activity_grid.h"

namespace ratslam {

/// Raw deflate stream, with the checksum and size that a zip file needs.
class Deflater {
 public:
  Deflater();
  ~Deflater();
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  void add(const void* data, std::size_t size);
  /// Ends the stream. @return the compressed bytes
  const std::vector<std::uint8_t>& finish();
  std::uint32_t crc() const { return crc_; }
  std::uint64_t size() const { return size_; }

 private:
  struct Zlib;
  void run(int flush);

  std::unique_ptr<Zlib> stream_;
  std::vector<std::uint8_t> bytes_;
  std::uint32_t crc_ = 0;
  std::uint64_t size_ = 0;
  bool finished_ = false;
};

class PoseCellRecording {
 public:
  /// Sizes in a zip file have 32 bits. Compression makes incompressible data larger by less than a percent.
  static constexpr std::uint64_t kMost = 4200000000;

  /// @param every  number of views from one snapshot to the next, at least 1
  /// @param most   size of all snapshots before compression [bytes], at most kMost
  explicit PoseCellRecording(std::size_t every, std::uint64_t most = kMost) : every_(every), most_(most) {}

  /// Offers the activity after a view event. The first one is always kept; a snapshot that would exceed the size is not.
  void add(Stamp stamp, const ActivityGrid& activity);
  std::size_t size() const { return stamps_.size(); }
  /// Number of snapshots that were not kept, because the file is full.
  std::size_t leftOut() const { return left_out_; }

  void write(std::ostream& file);

 private:
  std::size_t every_;
  std::uint64_t most_;
  std::size_t left_out_ = 0;
  std::size_t views_ = 0;
  std::vector<Stamp> stamps_;
  std::vector<int> shape_;  ///< of one snapshot
  Deflater activity_;
};

}  // namespace ratslam
