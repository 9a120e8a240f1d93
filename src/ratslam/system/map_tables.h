/// How States lie in the tables of a map file. docs/map_file.md documents the schema.
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "ratslam/common/state.h"
#include "sqlite.h"

namespace ratslam {

/// Makes the tables that every map file has.
void createMapTables(SqliteDatabase& database);

/// SQL table of a State with rows that has one of its own; empty for all others.
std::string mapTableOf(const std::string& state_path);

/// Writes States; what an earlier call of the same writer has written already is left as it is.
class StateTableWriter {
 public:
  explicit StateTableWriter(SqliteDatabase& database) : database_(database) {}

  /// Makes the database hold this State and nothing else. Within a transaction.
  void write(const State& state);
  /// Forgets what it has written: after a transaction that was taken back.
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

/// @throws std::runtime_error naming the file where something is missing or does not fit
State readStates(SqliteDatabase& database);

/// A number for bytes that changes with every bit of them.
std::uint64_t digestOf(const std::uint8_t* bytes, std::size_t size, std::uint64_t start = 0);

}  // namespace ratslam
