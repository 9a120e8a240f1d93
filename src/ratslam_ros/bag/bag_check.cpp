#include "ratslam_ros/bag/bag_check.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

namespace ratslam {
namespace {

constexpr std::uint8_t kBagHeader = 3;
constexpr std::uint8_t kIndexData = 4;
constexpr std::uint8_t kChunk = 5;
constexpr std::uint8_t kChunkInfo = 6;
constexpr std::uint8_t kConnection = 7;
/// A chunk that unpacks to so many bytes is never refused; larger ones are where they claim to hold more than so
/// many times what they are.
constexpr std::uint64_t kAlwaysFine = 64U << 20U;
constexpr std::uint64_t kMostPacked = 1000;

template <class T>
T numberIn(const std::string& bytes, std::size_t at = 0) {
  T number{};
  if (at + sizeof number <= bytes.size()) std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

/// A record's header: fields `length name=value`; none where they do not fill it exactly.
std::optional<std::map<std::string, std::string>> fieldsOf(const std::string& header) {
  std::map<std::string, std::string> fields;
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

class Checker {
 public:
  explicit Checker(const std::string& path) : path_(path), size_(std::filesystem::file_size(path)) {
    file_.rdbuf()->pubsetbuf(nullptr, 0);  // a few bytes here and there: a buffer would be filled for nothing
    file_.open(path, std::ios::binary);
  }

  void run() {
    const std::string version = "#ROSBAG V2.0\n";
    // What only resembles it rosbag might take for a bag of another kind, whose lengths nobody has checked.
    if (read(0, version.size()) != version) refuse(0, "it does not begin with #ROSBAG V2.0");
    for (std::uint64_t at = version.size(); at < size_;) {
      records_.insert(at);
      at = checkRecord(at);
    }
    if (index_ && *index_ != size_ && records_.count(*index_) == 0) {
      refuse(*index_, "no record is where the header says that the index begins");
    }
    for (const std::uint64_t chunk : named_chunks_) {
      if (chunks_.count(chunk) == 0) refuse(chunk, "no chunk is where the index names one");
    }
  }

 private:
  [[noreturn]] void refuse(std::uint64_t at, const std::string& reason) const {
    throw std::runtime_error(path_ + ": not a readable bag, or a truncated one: byte " + std::to_string(at) +
                             ": " + reason);
  }

  std::string read(std::uint64_t at, std::uint64_t count) {
    std::string bytes(static_cast<std::size_t>(std::min(count, size_ - std::min(at, size_))), '\0');
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(at));
    file_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return bytes;
  }

  /// The length at `at` of something that ends before `end`.
  std::uint64_t lengthAt(std::uint64_t at, std::uint64_t end) {
    const std::uint64_t length = at + 4 <= end ? numberIn<std::uint32_t>(read(at, 4)) : end;
    if (at + 4 + length > end)
      refuse(at,
             "a record reaches beyond the end of " + std::string(end == size_ ? "the file" : "its chunk"));
    return length;
  }

  /// The fields of the header whose length stands at `at`.
  std::map<std::string, std::string> headerAt(std::uint64_t at, std::uint64_t length) {
    const auto fields = fieldsOf(read(at + 4, length));
    if (!fields) refuse(at, "the fields of a record's header do not fit into it");
    return *fields;
  }

  /// @return where the next record begins
  std::uint64_t checkRecord(std::uint64_t at) {
    const std::uint64_t header_length = lengthAt(at, size_);
    const auto fields = headerAt(at, header_length);
    const std::uint64_t data = at + 4 + header_length + 4;
    const std::uint64_t length = lengthAt(data - 4, size_);
    const auto field = [&fields](const char* name) {
      const auto found = fields.find(name);
      return found == fields.end() ? std::string() : found->second;
    };
    const auto kind = numberIn<std::uint8_t>(field("op"));
    if (kind == kChunk) {
      chunks_.insert(at);
      chunk_ = data;
      chunk_size_ = numberIn<std::uint32_t>(field("size"));
      packed_ = field("compression") != "none";
      const bool too_much =
          packed_ ? chunk_size_ > std::max(kAlwaysFine, kMostPacked * length) : chunk_size_ > length;
      if (too_much) {
        refuse(at, "a chunk of " + std::to_string(length) + " bytes claims to hold " +
                       std::to_string(chunk_size_));
      }
    }
    // Without an index the recording was cut off, which rosbag says: its end may well lie within a record.
    if (kind == kBagHeader) {
      const auto index = numberIn<std::uint64_t>(field("index_pos"));
      if (index == 0) return size_;
      index_ = index;
    }
    if (kind == kConnection) headerAt(data - 4, length);  // which describes the connection in fields, too
    if (kind == kIndexData) checkIndex(at, read(data, length));
    if (kind == kChunkInfo) named_chunks_.insert(numberIn<std::uint64_t>(field("chunk_pos")));
    return data + length;
  }

  /// @param entries  stamp and place within the chunk before it, 12 bytes each
  void checkIndex(std::uint64_t at, const std::string& entries) {
    constexpr std::size_t kEntry = 12;
    for (std::size_t i = 0; i + kEntry <= entries.size(); i += kEntry) {
      const std::uint64_t offset = numberIn<std::uint32_t>(entries, i + 8);
      if (offset + 8 > chunk_size_) refuse(at, "an index points out of its chunk");
      if (packed_) continue;
      const std::uint64_t header_length = lengthAt(chunk_ + offset, chunk_ + chunk_size_);
      headerAt(chunk_ + offset, header_length);
      lengthAt(chunk_ + offset + 4 + header_length, chunk_ + chunk_size_);
    }
  }

  std::string path_;
  std::ifstream file_;
  std::uint64_t size_;
  std::set<std::uint64_t> records_;  ///< where each begins
  std::optional<std::uint64_t> index_;
  std::set<std::uint64_t> chunks_;
  std::set<std::uint64_t> named_chunks_;
  std::uint64_t chunk_ = 0;  ///< where the data of the last chunk begin
  std::uint64_t chunk_size_ = 0;
  bool packed_ = false;
};

}  // namespace

void checkBagRecords(const std::string& path) { Checker(path).run(); }

}  // namespace ratslam
