/// The map file: a checkpoint of everything that a run has learned, in one SQLite database.
///
/// A checkpoint consists of the States of one or several parts of the system (common/state.h), their parameters,
/// and a stamp. Templates, the views' ties to the pose cells, experiences and links have their own tables with a
/// row each. Everything else is stored in compressed chunks (docs/map_file.md has every table and column).
///
/// Saving is one transaction. If a crash, a full disk or a power failure interrupts it, the previous checkpoint is
/// restored, at the latest when the file is read. Only chunks and rows that changed are written. SQLite uses its
/// rollback journal and no write-ahead log: so after a complete save the map is one file, which can be copied, and read
/// from a read-only folder. A digest over the whole content detects damage that SQLite itself does not notice.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "ratslam/common/stamp.h"
#include "ratslam/common/state.h"

namespace ratslam {

/// Version of the file's tables. Older ones are migrated when they are opened for writing.
constexpr int kMapFileVersion = 1;

/// A part of the mapping without an interruption.
struct MapSession {
  std::string version;    ///< of the program
  Stamp first_stamp = 0;  ///< of the messages
  Stamp last_stamp = 0;

  bool operator==(const MapSession& other) const {
    return version == other.version && first_stamp == other.first_stamp && last_stamp == other.last_stamp;
  }
};

/// Content of a map file.
struct MapCheckpoint {
  Stamp stamp = 0;  ///< messages up to this stamp have been processed
  std::map<std::string, std::string> parameters;
  std::vector<MapSession> sessions;
  State state;  ///< a child for each part: local_view, pose_cells, experience_map, odometry, ...
};

/// Parameters by key. Different values have different texts.
template <class Params>
std::map<std::string, std::string> parameterTexts(Params params);

/// Refuses a checkpoint that was made with other parameters.
/// @throws std::runtime_error naming the file, the first key that differs, and both values
void requireParameters(const std::string& path, const MapCheckpoint& checkpoint,
                       const std::map<std::string, std::string>& parameters);

/// Reads a map file. The file does not change, unless a save was interrupted: then that save is undone, for which the
/// file and its folder must be writable.
/// @throws std::runtime_error "FILE: what is wrong with it": missing, not a map file, of a newer version, damaged, or
/// the interrupted save cannot be undone. MapUnread if the file may be sound: MapBusy if another program has locked it for
/// longer than 2 s
MapCheckpoint loadMapFile(const std::string& path);

/// A file that may be sound: it is busy, a newer program wrote it, or it may not be opened. It must not be replaced.
class MapUnread : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Another program uses the file at present.
class MapBusy : public MapUnread {
 public:
  using MapUnread::MapUnread;
};

/// Lock of the one program that writes to a map. The operating system releases it when that program ends in any way.
class MapLock {
 public:
  /// @param map a file. The lock is on FILE.lock beside it, which is removed with the lock. PART.b.db has the lock of
  /// PART.a.db, because a node writes the two in turn.
  /// @throws MapBusy if another program holds the lock; std::runtime_error if the folder cannot be written
  explicit MapLock(const std::string& map);
  ~MapLock();
  MapLock(const MapLock&) = delete;
  MapLock& operator=(const MapLock&) = delete;

 private:
  std::string path_;
  int file_ = -1;
};

/// Writes a map file. If another program may write to it, hold its MapLock.
class MapWriter {
 public:
  /// Creates the file if it is missing.
  /// @throws std::runtime_error if the folder or file cannot be written, or it is not a map file
  explicit MapWriter(const std::string& path);
  ~MapWriter();
  MapWriter(const MapWriter&) = delete;
  MapWriter& operator=(const MapWriter&) = delete;

  /// Replaces the content of the file. @throws std::runtime_error naming file and cause; the file is then unchanged
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
