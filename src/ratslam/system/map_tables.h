/// Writing and reading of States in the tables of a map file. docs/map_file.md documents the schema.
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "ratslam/common/state.h"
#include "sqlite.h"

namespace ratslam {

/// Creates the tables that every map file has.
void createMapTables(SqliteDatabase& database);

/// Name of the SQL table for the rows of a State; empty if it has none.
std::string mapTableOf(const std::string& state_path);

/// Writes States. Does not write again what an earlier call of the same writer has written.
class StateTableWriter {
 public:
  explicit StateTableWriter(SqliteDatabase& database) : database_(database) {}

  /// Replaces the content of the database by this State. To be called within a transaction.
  void write(const State& state);
  /// Forgets what has been written. To be called after a transaction was rolled back.
  void forget();

 private:
  using Hashes = std::vector<std::uint64_t>;

  void writeState(const State& state, const std::string& path);
  void writeArray(const std::string& path, const std::string& name, const StateArray& array,
                  const std::string& table);
  void writeChunks(const std::string& key, const std::string& path, const std::string& name,
                   const std::string& kind, const std::uint8_t* bytes, std::size_t size);
  void writeRows(const State& state, const std::string& path, const std::string& table);
  void removeOthers();

  SqliteDatabase& database_;
  std::unordered_map<std::string, Hashes> written_;       ///< of chunks and rows, by what they belong to
  std::unordered_map<std::string, std::string> columns_;  ///< of each SQL table
  std::unordered_map<std::string, bool> seen_;            ///< in the present call
};

/// @throws std::runtime_error naming the file if something is missing or does not fit
State readStates(SqliteDatabase& database);

/// Digest of bytes: changes with every bit of them.
std::uint64_t digestOf(const std::uint8_t* bytes, std::size_t size, std::uint64_t start = 0);

}  // namespace ratslam
