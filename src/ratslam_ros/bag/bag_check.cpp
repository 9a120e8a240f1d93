#include "ratslam_ros/bag/bag_check.h"

#include <bzlib.h>
#include <roslz4/lz4s.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace ratslam {
namespace {

constexpr std::uint8_t kMessage = 2;
constexpr std::uint8_t kBagHeader = 3;
constexpr std::uint8_t kIndexData = 4;
constexpr std::uint8_t kChunk = 5;
constexpr std::uint8_t kChunkInfo = 6;
constexpr std::uint8_t kConnection = 7;
/// A chunk that unpacks to at most kAlwaysFine bytes is never refused. A larger one is refused if it claims to unpack to
/// more than kMostPacked times its size.
constexpr std::uint64_t kAlwaysFine = 64U << 20U;
constexpr std::uint64_t kMostPacked = 1000;

[[noreturn]] void refuse(const std::string& path, std::uint64_t at, const std::string& reason) {
  throw std::runtime_error(path + ": not a readable bag, or a truncated one: byte " + std::to_string(at) +
                           ": " + reason);
}

/// Description of a file whose first bytes are not those of a bag.
std::string whatElse(const std::string& begin) {
  std::string otherwise = "it does not begin with #ROSBAG V2.0";
  if (begin.rfind("\x89MCAP", 0) == 0) {
    return otherwise + " but as a bag of ROS 2; rosbags-convert makes one of ROS 1 of it";
  }
  if (begin.rfind("SQLite format", 0) == 0) {
    return otherwise +
           " but as a database: if it is a bag of ROS 2, rosbags-convert makes one of ROS 1 of it";
  }
  return otherwise;
}

template <class T>
T numberIn(const std::string& bytes, std::size_t at = 0) {
  T number{};
  if (at + sizeof number <= bytes.size()) std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

using Fields = std::map<std::string, std::string>;

/// Fields `length name=value` of a record's header; none if they do not fill it exactly.
std::optional<Fields> fieldsOf(const std::string& header) {
  Fields fields;
  std::size_t at = 0;
  while (at + 4 <= header.size()) {
    const std::size_t length = numberIn<std::uint32_t>(header, at);
    if (at + 4 + length > header.size()) return std::nullopt;
    const std::string field = header.substr(at + 4, length);
    const std::size_t equals = field.find('=');
    if (equals == std::string::npos) return std::nullopt;
    fields[field.substr(0, equals)] = field.substr(equals + 1);
    at += 4 + length;
  }
  return at == header.size() ? std::make_optional(fields) : std::nullopt;
}

std::string fieldOf(const Fields& fields, const char* name) {
  const auto found = fields.find(name);
  return found == fields.end() ? std::string() : found->second;
}

std::uint8_t kindOf(const Fields& fields) { return numberIn<std::uint8_t>(fieldOf(fields, "op")); }

/// Bytes that contain records: those of a file, of a chunk in it, or of an unpacked chunk.
struct Span {
  std::function<std::string(std::uint64_t at, std::uint64_t count)> read;
  std::uint64_t end;
  const char* name;
  std::function<void(std::uint64_t at, const std::string& reason)> refuse;  ///< throws

  /// The length stored at `at`. Refuses one that leaves the span.
  std::uint64_t lengthAt(std::uint64_t at) const {
    const std::uint64_t length = at + 4 <= end ? numberIn<std::uint32_t>(read(at, 4)) : end;
    if (at + 4 + length > end) refuse(at, std::string("a record reaches beyond the end of ") + name);
    return length;
  }

  /// The fields of the header whose length is stored at `at`.
  Fields fieldsAt(std::uint64_t at, std::uint64_t length) const {
    const auto fields = fieldsOf(read(at + 4, length));
    if (!fields) refuse(at, "the fields of a record's header do not fit into it");
    return *fields;
  }

  /// Requires a message at `at`, as an index states.
  void requireMessage(std::uint64_t at) const {
    const std::uint64_t header_length = lengthAt(at);
    if (kindOf(fieldsAt(at, header_length)) != kMessage) refuse(at, "an index points at what is no message");
    lengthAt(at + 4 + header_length);
  }
};

class FileBytes {
 public:
  explicit FileBytes(const std::string& path) : size_(std::filesystem::file_size(path)) {
    file_.rdbuf()->pubsetbuf(nullptr,
                             0);  // for a few bytes at scattered positions a buffer would only cost time
    file_.open(path, std::ios::binary);
  }

  std::uint64_t size() const { return size_; }
  std::string read(std::uint64_t at, std::uint64_t count) {
    std::string bytes(static_cast<std::size_t>(std::min(count, size_ - std::min(at, size_))), '\0');
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(at));
    file_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return bytes;
  }

 private:
  std::ifstream file_;
  std::uint64_t size_;
};

/// Reads and checks the records of a file.
class Records {
 public:
  explicit Records(const std::string& path)
      : path_(path),
        file_(path),
        whole_(
            span(file_.size(), "the file", "; rosbag reindex " + path + " keeps the chunks that are whole")),
        chunk_span_(whole_) {}

  std::vector<BagCheck::PackedChunk> check() {
    const std::string version = "#ROSBAG V2.0\n";
    // rosbag may take a similar line for a bag of another version, whose lengths are not checked here.
    const std::string begin = file_.read(0, version.size());
    if (begin != version) refuse(path_, 0, whatElse(begin));
    for (std::uint64_t at = version.size(); at < whole_.end;) {
      records_.insert(at);
      at = checkRecord(at);
    }
    if (index_ && *index_ != whole_.end && records_.count(*index_) == 0) {
      refuse(path_, *index_, "no record is where the header says that the index begins");
    }
    for (const std::uint64_t chunk : named_chunks_) {
      if (chunks_.count(chunk) == 0) refuse(path_, chunk, "no chunk is where the index names one");
    }
    return std::move(packed_);
  }

 private:
  /// @param way_out  advice that is added to error messages
  Span span(std::uint64_t end, const char* name, const std::string& way_out = "") {
    return {[this](std::uint64_t at, std::uint64_t count) { return file_.read(at, count); }, end, name,
            [this, way_out](std::uint64_t at, const std::string& reason) {
              refuse(path_, at, reason + way_out);
            }};
  }

  /// @return begin of the next record
  std::uint64_t checkRecord(std::uint64_t at) {
    const std::uint64_t header_length = whole_.lengthAt(at);
    const Fields fields = whole_.fieldsAt(at, header_length);
    const std::uint64_t data = at + 4 + header_length + 4;
    const std::uint64_t length = whole_.lengthAt(data - 4);
    const std::uint8_t kind = kindOf(fields);
    if (kind == kChunk) beginChunk({at, data, length, 0, fieldOf(fields, "compression"), 0, {}}, fields);
    // Without an index the recording was cut off, perhaps within a record. rosbag reports that.
    if (kind == kBagHeader) {
      const auto index = numberIn<std::uint64_t>(fieldOf(fields, "index_pos"));
      if (index == 0) return whole_.end;
      index_ = index;
    }
    if (kind == kConnection)
      whole_.fieldsAt(data - 4, length);  // its data are fields, too, which describe the connection
    if (kind == kIndexData) checkIndex(at, file_.read(data, length));
    if (kind == kChunkInfo) named_chunks_.insert(numberIn<std::uint64_t>(fieldOf(fields, "chunk_pos")));
    return data + length;
  }

  void beginChunk(BagCheck::PackedChunk chunk, const Fields& fields) {
    chunks_.insert(chunk.at);
    chunk.unpacked = numberIn<std::uint32_t>(fieldOf(fields, "size"));
    is_packed_ = chunk.compression != "none";
    const std::uint64_t most = is_packed_ ? std::max(kAlwaysFine, kMostPacked * chunk.length) : chunk.length;
    if (chunk.unpacked > most) {
      refuse(path_, chunk.at,
             "a chunk of " + std::to_string(chunk.length) + " bytes claims to hold " +
                 std::to_string(chunk.unpacked));
    }
    chunk_data_ = chunk.data;
    chunk_size_ = chunk.unpacked;
    chunk_span_ = span(chunk.data + chunk.unpacked, "its chunk");
    if (is_packed_) packed_.push_back(std::move(chunk));
  }

  /// @param entries  stamp and position within the chunk before it, 12 bytes each
  void checkIndex(std::uint64_t at, const std::string& entries) {
    constexpr std::size_t kEntry = 12;
    for (std::size_t i = 0; i + kEntry <= entries.size(); i += kEntry) {
      const auto offset = numberIn<std::uint32_t>(entries, i + 8);
      if (std::uint64_t{offset} + 8 > chunk_size_) refuse(path_, at, "an index points out of its chunk");
      if (is_packed_) {
        const Stamp recorded = Stamp{numberIn<std::uint32_t>(entries, i)} * 1'000'000'000 +
                               Stamp{numberIn<std::uint32_t>(entries, i + 4)};
        BagCheck::PackedChunk& chunk = packed_.back();
        chunk.first = chunk.messages.empty() ? recorded : std::min(chunk.first, recorded);
        chunk.messages.push_back(offset);
      } else {
        chunk_span_.requireMessage(chunk_data_ + offset);
      }
    }
  }

  std::string path_;
  FileBytes file_;
  Span whole_;
  Span chunk_span_;                  ///< up to the end of the last chunk, if that is not packed
  std::set<std::uint64_t> records_;  ///< begin of each record
  std::optional<std::uint64_t> index_;
  std::set<std::uint64_t> chunks_;
  std::set<std::uint64_t> named_chunks_;
  std::vector<BagCheck::PackedChunk> packed_;
  std::uint64_t chunk_data_ = 0;  ///< begin of the last chunk's data
  std::uint64_t chunk_size_ = 0;
  bool is_packed_ = false;
};

/// Unpacks a compressed chunk as rosbag does, up to the size in its header; none if it is damaged.
std::optional<std::string> unpack(std::string packed, const std::string& compression,
                                  std::uint64_t unpacked) {
  std::string bytes(static_cast<std::size_t>(unpacked), '\0');
  auto length = static_cast<unsigned int>(unpacked);
  const auto packed_length = static_cast<unsigned int>(packed.size());
  bool good = false;
  if (compression == "bz2") {
    good = BZ2_bzBuffToBuffDecompress(bytes.data(), &length, packed.data(), packed_length, 0, 0) == BZ_OK;
  } else if (compression == "lz4") {
    good = roslz4_buffToBuffDecompress(packed.data(), packed_length, bytes.data(), &length) == ROSLZ4_OK;
  }
  if (!good) return std::nullopt;
  bytes.resize(std::min<std::size_t>(length, bytes.size()));
  return bytes;
}

void lookInto(const std::string& path, const BagCheck::PackedChunk& chunk) {
  const auto bytes =
      unpack(FileBytes(path).read(chunk.data, chunk.length), chunk.compression, chunk.unpacked);
  // In place of missing bytes rosbag would use those of an earlier chunk.
  if (!bytes || bytes->size() != chunk.unpacked) {
    refuse(path, chunk.at,
           "a chunk does not unpack to the " + std::to_string(chunk.unpacked) + " bytes that it claims");
  }
  const Span span{[&](std::uint64_t at, std::uint64_t count) { return bytes->substr(at, count); },
                  bytes->size(), "its chunk",
                  [&](std::uint64_t at, const std::string& reason) {
                    refuse(path, chunk.at,
                           "byte " + std::to_string(at) + " of what a chunk unpacks to: " + reason);
                  }};
  for (const std::uint32_t message : chunk.messages) span.requireMessage(message);
}

}  // namespace

BagCheck::BagCheck(const std::string& path) : path_(path), packed_(Records(path).check()) {
  std::sort(packed_.begin(), packed_.end(), [](const PackedChunk& a, const PackedChunk& b) {
    return std::tie(a.first, a.at) > std::tie(b.first, b.at);
  });
}

void BagCheck::beforeReading(Stamp recorded) {
  for (; !packed_.empty() && packed_.back().first <= recorded; packed_.pop_back())
    lookInto(path_, packed_.back());
}

}  // namespace ratslam
