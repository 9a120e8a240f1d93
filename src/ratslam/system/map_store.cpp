#include "ratslam/system/map_store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>

#include "map_tables.h"
#include "ratslam/common/text_file.h"
#include "sqlite.h"

namespace ratslam {
namespace {

constexpr std::int64_t kApplicationId = 0x52534C4D;  // "RSLM"

std::uint64_t checkpointDigest(const MapCheckpoint& checkpoint) {
  const std::vector<std::uint8_t> bytes = checkpoint.state.toBytes();
  std::uint64_t digest = digestOf(bytes.data(), bytes.size(), static_cast<std::uint64_t>(checkpoint.stamp));
  const auto add = [&digest](const std::string& text) {
    digest = digestOf(reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), digest);
  };
  for (const auto& [key, value] : checkpoint.parameters) {
    add(key);
    add(value);
  }
  for (const MapSession& session : checkpoint.sessions) {
    add(session.version);
    add(std::to_string(session.first_stamp) + ' ' + std::to_string(session.last_stamp));
  }
  return digest;
}

/// Whether a path still names an opened file.
bool isFile(int file, const std::string& path) {
  struct stat opened {};
  struct stat there {};
  return ::fstat(file, &opened) == 0 && ::stat(path.c_str(), &there) == 0 && opened.st_ino == there.st_ino &&
         opened.st_dev == there.st_dev;
}

/// The two checkpoints of a part, PART.a.db and PART.b.db, have one writer and one lock.
std::string lockOf(const std::string& map) {
  const std::string second = ".b.db";
  return (endsWith(map, second) ? map.substr(0, map.size() - second.size()) + ".a.db" : map) + ".lock";
}

/// Version of the tables of an opened file. @throws std::runtime_error if it is no map file, or newer
int versionOf(SqliteDatabase& database) {
  if (database.number("PRAGMA application_id") != kApplicationId) database.fail("it is not a map file");
  const std::int64_t version = database.number("PRAGMA user_version");
  const std::string what = "its version is " + std::to_string(version) +
                           "; this program reads versions 1 to " + std::to_string(kMapFileVersion);
  if (version > kMapFileVersion) throw MapUnread(database.path() + ": " + what);
  if (version < 1) database.fail(what);
  return static_cast<int>(version);
}

/// Migrates the tables of an older file, version by version.
void migrate(SqliteDatabase& database) {
  // steps[N - 1] migrates the tables from version N to N + 1.
  static const std::vector<const char*> steps{};
  for (auto version = static_cast<std::size_t>(versionOf(database)); version <= steps.size(); ++version) {
    database.run("BEGIN IMMEDIATE");
    database.run(steps[version - 1]);
    database.run("PRAGMA user_version = " + std::to_string(version + 1) + "; COMMIT");
  }
}

MapCheckpoint read(SqliteDatabase& database) {
  versionOf(database);
  MapCheckpoint checkpoint;
  SqliteStatement head(database, "SELECT stamp, digest FROM checkpoint");
  if (!head.step()) database.fail("it holds no checkpoint");
  checkpoint.stamp = head.integer(0);
  const auto digest = static_cast<std::uint64_t>(head.integer(1));
  SqliteStatement parameters(database, "SELECT key, value FROM parameter");
  while (parameters.step()) checkpoint.parameters[parameters.text(0)] = parameters.text(1);
  SqliteStatement sessions(database, "SELECT version, first_stamp, last_stamp FROM session ORDER BY id");
  while (sessions.step()) {
    checkpoint.sessions.push_back({sessions.text(0), sessions.integer(1), sessions.integer(2)});
  }
  checkpoint.state = readStates(database);
  if (checkpointDigest(checkpoint) != digest)
    database.fail("it is damaged: its content is not what was saved");
  return checkpoint;
}

}  // namespace

void requireParameters(const std::string& path, const MapCheckpoint& checkpoint,
                       const std::map<std::string, std::string>& parameters) {
  for (const auto& [key, value] : checkpoint.parameters) {
    const auto now = parameters.find(key);
    if (now == parameters.end()) {
      throw std::runtime_error(path + ": made with the parameter " + key +
                               ", which is none of those here: another odometry or another version made it");
    }
    const bool matters = key != "threads";  // results do not depend on it, and machines differ in it
    if (matters && now->second != value) {
      throw std::runtime_error(path + ": made with " + key + " = " + value + ", but it is " + now->second +
                               " now; a map goes on with the parameters that it was made with");
    }
  }
}

MapLock::MapLock(const std::string& map) : path_(lockOf(map)) {
  // The previous holder may have removed the file after it was opened here. A lock on a removed file locks out nobody.
  do {
    if (file_ >= 0) ::close(file_);
    file_ = ::open(path_.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
    if (file_ < 0) throw std::runtime_error(map + ": cannot write beside it: " + std::strerror(errno));
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
      ::close(file_);
      throw MapBusy(map + ": another program writes to it; one map has one writer");
    }
  } while (!isFile(file_, path_));
}

MapLock::~MapLock() {
  ::unlink(path_.c_str());  // before the lock is released, so that it is not another program's file
  ::close(file_);
}

MapCheckpoint loadMapFile(const std::string& path) {
  SqliteDatabase database(path, SqliteDatabase::Access::kRead);
  try {
    return read(database);
  } catch (const std::runtime_error& error) {
    const std::string what = error.what();
    if (what.compare(0, path.size(), path) == 0) throw;
    database.fail("it is damaged: " + what);
  } catch (const std::exception& error) {  // a damaged number can cause any error
    database.fail(std::string("it is damaged: ") + error.what());
  }
}

struct MapWriter::Impl {
  explicit Impl(const std::string& path) : database(path, SqliteDatabase::Access::kWrite), tables(database) {}

  SqliteDatabase database;
  StateTableWriter tables;
};

MapWriter::MapWriter(const std::string& path) : impl_(std::make_unique<Impl>(path)) {
  SqliteDatabase& database = impl_->database;
  if (database.number("SELECT count(*) FROM sqlite_master") == 0) {
    database.run("PRAGMA application_id = " + std::to_string(kApplicationId) +
                 "; PRAGMA user_version = " + std::to_string(kMapFileVersion));
    createMapTables(database);
  } else {
    migrate(database);
  }
}

MapWriter::~MapWriter() = default;

const std::string& MapWriter::path() const { return impl_->database.path(); }

void MapWriter::save(const MapCheckpoint& checkpoint) {
  SqliteDatabase& database = impl_->database;
  database.run("BEGIN IMMEDIATE");
  try {
    database.run("DELETE FROM checkpoint; DELETE FROM parameter; DELETE FROM session");
    SqliteStatement head(database, "INSERT INTO checkpoint VALUES (0, ?, ?)");
    head.bind(1, checkpoint.stamp);
    head.bind(2, static_cast<std::int64_t>(checkpointDigest(checkpoint)));
    head.runOnce();
    SqliteStatement parameter(database, "INSERT INTO parameter VALUES (?, ?)");
    for (const auto& [key, value] : checkpoint.parameters) {
      parameter.bind(1, key);
      parameter.bind(2, value);
      parameter.runOnce();
    }
    SqliteStatement session(database,
                            "INSERT INTO session(version, first_stamp, last_stamp) VALUES (?, ?, ?)");
    for (const MapSession& each : checkpoint.sessions) {
      session.bind(1, each.version);
      session.bind(2, each.first_stamp);
      session.bind(3, each.last_stamp);
      session.runOnce();
    }
    impl_->tables.write(checkpoint.state);
    database.run("COMMIT");
  } catch (...) {
    sqlite3_exec(database.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
    impl_->tables.forget();
    throw;
  }
}

}  // namespace ratslam
