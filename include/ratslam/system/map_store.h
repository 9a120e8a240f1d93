/// The map file: everything a run has learned, in one SQLite database that outlives it.
///
/// A file holds the States of one or several parts of the system (common/state.h), the parameters they were
/// made with, and at which stamp they were taken: a checkpoint. Templates, the views' ties to the pose cells,
/// experiences and links lie in tables of their own, a row each; all else in compressed chunks
/// (docs/map_file.md has every table and column).
///
/// Saving is one transaction: whatever interrupts it - a crash, a full disk, the power - the file holds the
/// checkpoint before. Only chunks and rows that changed are written. SQLite's rollback journal is used, not a
/// write-ahead log: at rest the map is one file, which can be copied and read where nothing can be written. A
/// digest over the whole content tells damage that SQLite itself does not notice.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "ratslam/common/stamp.h"
#include "ratslam/common/state.h"

namespace ratslam {

/// Version of the file's tables. Older ones are migrated when they are opened for writing.
constexpr int kMapFileVersion = 1;

/// A stretch of mapping without an interruption.
struct MapSession {
  std::string version;    ///< of the program
  Stamp first_stamp = 0;  ///< of the messages
  Stamp last_stamp = 0;

  bool operator==(const MapSession& other) const {
    return version == other.version && first_stamp == other.first_stamp && last_stamp == other.last_stamp;
  }
};

/// What a map file holds.
struct MapCheckpoint {
  Stamp stamp = 0;  ///< up to which messages have been taken in
  std::map<std::string, std::string> parameters;
  std::vector<MapSession> sessions;
  State state;  ///< a child for each part: local_view, pose_cells, experience_map, odometry, ...
};

/// Parameters by key, as text that tells every value apart from every other.
template <class Params>
std::map<std::string, std::string> parameterTexts(Params params);

/// Refuses a checkpoint that was made with other parameters, naming the first that differs.
/// @throws std::runtime_error naming file, key and both values
void requireParameters(const std::string& path, const MapCheckpoint& checkpoint,
                       const std::map<std::string, std::string>& parameters);

/// Reads a map file; it is not changed, nor is the folder it lies in.
/// @throws std::runtime_error "FILE: what is wrong with it": missing, no map file, of a newer version,
/// damaged
MapCheckpoint loadMapFile(const std::string& path);

/// Held by the one program that writes to a map; the system lets go of it however that program ends.
class MapLock {
 public:
  /// @param map a file; FILE.lock beside it is what is locked. It is gone when the lock is.
  /// @throws std::runtime_error where another program holds it, or the folder cannot be written
  explicit MapLock(const std::string& map);
  ~MapLock();
  MapLock(const MapLock&) = delete;
  MapLock& operator=(const MapLock&) = delete;

 private:
  std::string path_;
  int file_ = -1;
};

/// Writes a map file. Whoever may not be the only one holds its MapLock.
class MapWriter {
 public:
  /// Makes the file where it is missing.
  /// @throws std::runtime_error where the folder or file cannot be written, or it is no map file
  explicit MapWriter(const std::string& path);
  ~MapWriter();
  MapWriter(const MapWriter&) = delete;
  MapWriter& operator=(const MapWriter&) = delete;

  /// Replaces what the file holds. @throws std::runtime_error naming file and cause; it then holds what it
  /// held
  void save(const MapCheckpoint& checkpoint);

  const std::string& path() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

template <class Params>
std::map<std::string, std::string> parameterTexts(Params params) {
  std::map<std::string, std::string> texts;
  params.visitFields([&texts](const std::string& key, const auto& value, const auto&, const char*) {
    std::ostringstream text;
    text.precision(std::numeric_limits<double>::max_digits10);
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::vector<double>>) {
      for (const double number : value) text << number << ' ';
    } else {
      text << value;
    }
    texts[key] = text.str();
  });
  return texts;
}

}  // namespace ratslam
