#include "ratslam/system/pose_cell_recording.h"

#include <zlib.h>

#include <ostream>
#include <stdexcept>
#include <string>

namespace ratslam {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kHeaderSize = 128;  // fixed size of an array's header, so that it can be written last
constexpr std::uint16_t kVersion = 20;
constexpr std::uint16_t kDeflate = 8;
constexpr std::uint16_t kFirstOfJanuary1980 = 33;

void put(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// Header of an array in numpy's format, version 1.0.
Bytes arrayHeader(const std::string& type, const std::string& shape) {
  std::string text = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  constexpr std::size_t kBeforeText = 10;
  text.append(kHeaderSize - kBeforeText - 1 - text.size(), ' ');
  text += '\n';
  Bytes bytes = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0};
  put(bytes, text.size(), 2);
  bytes.insert(bytes.end(), text.begin(), text.end());
  return bytes;
}

/// A deflate block of uncompressed bytes that is not the last one.
Bytes storedBlock(const Bytes& content) {
  Bytes bytes = {0};
  put(bytes, content.size(), 2);
  put(bytes, ~content.size() & 0xffffU, 2);
  bytes.insert(bytes.end(), content.begin(), content.end());
  return bytes;
}

/// Zip archive of arrays. Each file consists of a header and the compressed numbers.
class Archive {
 public:
  void add(const std::string& name, const Bytes& header, Deflater& numbers) {
    const Bytes& compressed = numbers.finish();
    const Bytes block = storedBlock(header);
    const auto header_crc = crc32(0, header.data(), static_cast<uInt>(header.size()));
    Bytes description;
    put(description, kVersion, 2);
    put(description, 0, 2);  // flags
    put(description, kDeflate, 2);
    put(description, 0, 2);  // time
    put(description, kFirstOfJanuary1980, 2);
    put(description, crc32_combine(header_crc, numbers.crc(), static_cast<z_off_t>(numbers.size())), 4);
    put(description, block.size() + compressed.size(), 4);
    put(description, header.size() + numbers.size(), 4);
    put(description, name.size(), 2);
    put(description, 0, 2);  // extra field
    const std::size_t begin = bytes_.size();
    put(bytes_, 0x04034b50, 4);
    append(bytes_, description);
    bytes_.insert(bytes_.end(), name.begin(), name.end());
    append(bytes_, block);
    append(bytes_, compressed);
    put(directory_, 0x02014b50, 4);
    put(directory_, kVersion, 2);
    append(directory_, description);
    put(directory_, 0, 2 + 2 + 2);  // comment, disk, internal attributes
    put(directory_, 0, 4);          // external attributes
    put(directory_, begin, 4);
    directory_.insert(directory_.end(), name.begin(), name.end());
    ++files_;
  }

  Bytes finish() {
    const std::size_t begin = bytes_.size();
    append(bytes_, directory_);
    put(bytes_, 0x06054b50, 4);
    put(bytes_, 0, 4);  // disks
    put(bytes_, files_, 2);
    put(bytes_, files_, 2);
    put(bytes_, directory_.size(), 4);
    put(bytes_, begin, 4);
    put(bytes_, 0, 2);  // comment
    return std::move(bytes_);
  }

 private:
  static void append(Bytes& to, const Bytes& from) { to.insert(to.end(), from.begin(), from.end()); }

  Bytes bytes_;
  Bytes directory_;
  std::size_t files_ = 0;
};

}  // namespace

struct Deflater::Zlib {
  z_stream z{};
};

Deflater::Deflater() : stream_(std::make_unique<Zlib>()) {
  constexpr int kWithoutHead = -15;
  constexpr int kMemory = 8;
  if (deflateInit2(&stream_->z, Z_BEST_SPEED, Z_DEFLATED, kWithoutHead, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib cannot compress");
}

Deflater::~Deflater() { deflateEnd(&stream_->z); }

void Deflater::run(int flush) {
  std::uint8_t buffer[1 << 14];
  do {
    stream_->z.next_out = buffer;
    stream_->z.avail_out = sizeof(buffer);
    deflate(&stream_->z, flush);
    bytes_.insert(bytes_.end(), buffer, buffer + (sizeof(buffer) - stream_->z.avail_out));
  } while (stream_->z.avail_out == 0);
}

void Deflater::add(const void* data, std::size_t size) {
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  crc_ = static_cast<std::uint32_t>(crc32(crc_, bytes, static_cast<uInt>(size)));
  size_ += size;
  stream_->z.next_in = const_cast<std::uint8_t*>(bytes);
  stream_->z.avail_in = static_cast<uInt>(size);
  run(Z_NO_FLUSH);
}

const std::vector<std::uint8_t>& Deflater::finish() {
  if (!finished_) run(Z_FINISH);
  finished_ = true;
  return bytes_;
}

void PoseCellRecording::add(Stamp stamp, const ActivityGrid& activity) {
  if (views_++ % every_ != 0) return;
  const std::size_t cells = activity.offset(activity.nTh(), 0);
  if (activity_.size() + cells * sizeof(float) > most_) {
    ++left_out_;
    return;
  }
  stamps_.push_back(stamp);
  shape_ = {activity.nTh(), activity.nXy(), activity.nXy()};
  const std::vector<float> values(activity.data(), activity.data() + cells);
  activity_.add(values.data(), values.size() * sizeof(float));
}

void PoseCellRecording::write(std::ostream& file) {
  std::string shape = std::to_string(stamps_.size()) + ",";
  Deflater stamps;
  stamps.add(stamps_.data(), stamps_.size() * sizeof(Stamp));
  Archive archive;
  archive.add("stamps.npy", arrayHeader("<i8", shape), stamps);
  if (shape_.empty()) shape_ = {0, 0, 0};
  for (const int length : shape_) shape += " " + std::to_string(length) + ",";
  archive.add("activity.npy", arrayHeader("<f4", shape), activity_);
  const Bytes bytes = archive.finish();
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace ratslam
