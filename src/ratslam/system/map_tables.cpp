#include "map_tables.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <utility>

#include "map_columns.h"

namespace ratslam {
namespace {

constexpr std::size_t kChunkBytes = 64 * 1024;

/// States whose rows have their own SQL tables, for other programs to read.
constexpr std::array<std::pair<const char*, const char*>, 5> kTables{{
    {"local_view/templates", "template"},
    {"pose_cells/cells/view_input/view_links", "view_link"},
    {"pose_cells/cells/selector/selection", "pose_cell_experience"},
    {"experience_map/map/graph/experiences", "experience"},
    {"experience_map/map/graph/links", "link"},
}};

std::string shapeText(const StateShape& shape) {
  std::string text;
  for (const std::uint64_t size : shape) text += (text.empty() ? "" : " ") + std::to_string(size);
  return text;
}

/// Number of numbers in an entry of a column. An entry of one number is an SQL number, any other a blob.
std::size_t entryCount(const StateArray& array) {
  std::size_t count = 1;
  for (std::size_t i = 1; i < array.shape.size(); ++i) count *= static_cast<std::size_t>(array.shape[i]);
  return count;
}

/// Bytes [begin, end) of the entry of a row.
std::pair<std::size_t, std::size_t> entryOf(const StateArray& array, std::size_t row) {
  const std::size_t size = stateTypeSize(array.type);
  if (array.ends.empty()) {
    const std::size_t bytes = entryCount(array) * size;
    return {row * bytes, (row + 1) * bytes};
  }
  const auto end = static_cast<std::size_t>(array.ends[row]);
  return {(row == 0 ? 0 : static_cast<std::size_t>(array.ends[row - 1])) * size, end * size};
}

void bindNumber(SqliteStatement& statement, int place, StateType type, const std::uint8_t* bytes) {
  const auto integer = [&](auto value) { statement.bind(place, static_cast<std::int64_t>(value)); };
  switch (type) {
    case StateType::kInt8:
      return integer(numberAt<std::int8_t>(bytes));
    case StateType::kUint8:
      return integer(numberAt<std::uint8_t>(bytes));
    case StateType::kInt16:
      return integer(numberAt<std::int16_t>(bytes));
    case StateType::kUint16:
      return integer(numberAt<std::uint16_t>(bytes));
    case StateType::kInt32:
      return integer(numberAt<std::int32_t>(bytes));
    case StateType::kUint32:
      return integer(numberAt<std::uint32_t>(bytes));
    case StateType::kInt64:
      return integer(numberAt<std::int64_t>(bytes));
    case StateType::kUint64:
      return integer(numberAt<std::uint64_t>(bytes));
    case StateType::kFloat32:
      return statement.bind(place, static_cast<double>(numberAt<float>(bytes)));
    case StateType::kFloat64:
      return statement.bind(place, numberAt<double>(bytes));
  }
}

}  // namespace

std::string mapTableOf(const std::string& state_path) {
  for (const auto& [path, table] : kTables) {
    if (state_path == path) return table;
  }
  return {};
}

std::uint64_t digestOf(const std::uint8_t* bytes, std::size_t size, std::uint64_t start) {
  std::uint64_t digest = start ^ 0x9E3779B97F4A7C15ULL;
  const auto mix = [&digest](std::uint64_t word) {
    digest = (digest ^ word) * 0xFF51AFD7ED558CCDULL;  // odd, so every step is invertible and loses no bit
    digest ^= digest >> 29U;
  };
  std::size_t i = 0;
  for (; i + 8 <= size; i += 8) mix(numberAt<std::uint64_t>(bytes + i));
  for (; i < size; ++i) mix(bytes[i]);
  mix(size);
  return digest;
}

void createMapTables(SqliteDatabase& database) {
  // Columns without a type keep numbers unchanged. A REAL column would turn -0.0 into 0.
  database.run(R"(
    CREATE TABLE IF NOT EXISTS checkpoint(
      id INTEGER PRIMARY KEY CHECK (id = 0), stamp INTEGER NOT NULL, digest INTEGER NOT NULL);
    CREATE TABLE IF NOT EXISTS session(
      id INTEGER PRIMARY KEY, version TEXT NOT NULL, first_stamp INTEGER NOT NULL, last_stamp INTEGER NOT NULL);
    CREATE TABLE IF NOT EXISTS parameter(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
    CREATE TABLE IF NOT EXISTS state(path TEXT PRIMARY KEY, row_count INTEGER, sql_table TEXT) WITHOUT ROWID;
    CREATE TABLE IF NOT EXISTS array(
      state TEXT NOT NULL, name TEXT NOT NULL, type TEXT NOT NULL, shape TEXT NOT NULL,
      ragged INTEGER NOT NULL, PRIMARY KEY (state, name)) WITHOUT ROWID;
    CREATE TABLE IF NOT EXISTS chunk(
      state TEXT NOT NULL, name TEXT NOT NULL, kind TEXT NOT NULL, number INTEGER NOT NULL,
      size INTEGER NOT NULL, data BLOB NOT NULL, PRIMARY KEY (state, name, kind, number));
  )");
}

void StateTableWriter::forget() {
  written_.clear();
  columns_.clear();
}

void StateTableWriter::write(const State& state) {
  if (written_.empty()) {  // the content of the file is unknown
    database_.run("DELETE FROM state; DELETE FROM array; DELETE FROM chunk");
    for (const auto& [path, table] : kTables) database_.run("DROP TABLE IF EXISTS " + quoted(table));
    columns_.clear();
  }
  seen_.clear();
  database_.run("DELETE FROM state; DELETE FROM array");  // these rows are few and small
  writeState(state, "");
  removeOthers();
}

void StateTableWriter::writeState(const State& state, const std::string& path) {
  const std::string table = state.rows() ? mapTableOf(path) : "";
  SqliteStatement insert(database_, "INSERT INTO state VALUES (?, ?, ?)");
  insert.bind(1, path);
  if (state.rows()) {
    insert.bind(2, static_cast<std::int64_t>(*state.rows()));
  } else {
    insert.bindNull(2);
  }
  if (table.empty()) {
    insert.bindNull(3);
  } else {
    insert.bind(3, table);
  }
  insert.runOnce();
  for (const auto& [name, array] : state.arrays()) writeArray(path, name, array, table);
  if (!table.empty()) writeRows(state, path, table);
  for (const auto& [name, child] : state.children()) {
    writeState(child, path.empty() ? name : path + "/" + name);
  }
}

void StateTableWriter::writeArray(const std::string& path, const std::string& name, const StateArray& array,
                                  const std::string& table) {
  SqliteStatement insert(database_, "INSERT INTO array VALUES (?, ?, ?, ?, ?)");
  insert.bind(1, path);
  insert.bind(2, name);
  insert.bind(3, std::string(stateTypeName(array.type)));
  insert.bind(4, shapeText(array.shape));
  insert.bind(5, static_cast<std::int64_t>(array.ends.empty() ? 0 : 1));
  insert.runOnce();
  if (!table.empty()) return;
  const std::string key = path + '\n' + name + '\n';
  writeChunks(key + "numbers", path, name, "numbers", array.bytes.data(), array.bytes.size());
  if (array.ends.empty()) return;
  writeChunks(key + "ends", path, name, "ends", reinterpret_cast<const std::uint8_t*>(array.ends.data()),
              array.ends.size() * sizeof array.ends[0]);
}

void StateTableWriter::writeChunks(const std::string& key, const std::string& path, const std::string& name,
                                   const std::string& kind, const std::uint8_t* bytes, std::size_t size) {
  seen_[key] = true;
  Hashes& hashes = written_[key];
  SqliteStatement insert(database_, "INSERT OR REPLACE INTO chunk VALUES (?, ?, ?, ?, ?, ?)");
  std::size_t number = 0;
  std::vector<std::uint8_t> packed;
  for (std::size_t begin = 0; begin < size; begin += kChunkBytes, ++number) {
    const std::size_t length = std::min(kChunkBytes, size - begin);
    const std::uint64_t hash = digestOf(bytes + begin, length);
    if (number < hashes.size() && hashes[number] == hash) continue;
    hashes.resize(std::max(hashes.size(), number + 1));
    hashes[number] = hash;
    auto packed_size = compressBound(static_cast<uLong>(length));
    packed.resize(packed_size);
    compress2(packed.data(), &packed_size, bytes + begin, static_cast<uLong>(length), Z_BEST_SPEED);
    const bool smaller = packed_size < length;
    insert.bind(1, path);
    insert.bind(2, name);
    insert.bind(3, kind);
    insert.bind(4, static_cast<std::int64_t>(number));
    insert.bind(5, static_cast<std::int64_t>(length));
    insert.bindBlob(6, smaller ? packed.data() : bytes + begin, smaller ? packed_size : length);
    insert.runOnce();
  }
  if (number == hashes.size()) return;
  hashes.resize(number);
  SqliteStatement remove(database_,
                         "DELETE FROM chunk WHERE state = ? AND name = ? AND kind = ? AND number >= ?");
  remove.bind(1, path);
  remove.bind(2, name);
  remove.bind(3, kind);
  remove.bind(4, static_cast<std::int64_t>(number));
  remove.runOnce();
}

void StateTableWriter::writeRows(const State& state, const std::string& path, const std::string& table) {
  const std::string key = path + "\n\nrows";
  seen_[key] = true;
  Hashes& hashes = written_[key];
  std::string columns;
  std::string places = "?";
  for (const auto& [name, array] : state.arrays()) {
    columns += ", " + quoted(name);
    places += ", ?";
  }
  if (const auto found = columns_.find(table); found == columns_.end() || found->second != columns) {
    database_.run("DROP TABLE IF EXISTS " + quoted(table));
    database_.run("CREATE TABLE " + quoted(table) + "(row_id INTEGER PRIMARY KEY" + columns + ")");
    columns_[table] = columns;
    hashes.clear();
  }
  SqliteStatement insert(database_, "INSERT OR REPLACE INTO " + quoted(table) + " VALUES (" + places + ")");
  const auto rows = static_cast<std::size_t>(*state.rows());
  const std::size_t before = hashes.size();
  hashes.resize(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    std::uint64_t hash = row;
    for (const auto& [name, array] : state.arrays()) {
      const auto [begin, end] = entryOf(array, row);
      hash = digestOf(array.bytes.data() + begin, end - begin, hash);
    }
    if (row < before && hashes[row] == hash) continue;
    hashes[row] = hash;
    insert.bind(1, static_cast<std::int64_t>(row));
    int place = 2;
    for (const auto& [name, array] : state.arrays()) {
      const auto [begin, end] = entryOf(array, row);
      if (isNumberColumn(array)) {
        bindNumber(insert, place++, array.type, array.bytes.data() + begin);
      } else {
        insert.bindBlob(place++, array.bytes.data() + begin, end - begin);
      }
    }
    insert.runOnce();
  }
  if (before <= rows) return;
  SqliteStatement remove(database_, "DELETE FROM " + quoted(table) + " WHERE row_id >= ?");
  remove.bind(1, static_cast<std::int64_t>(rows));
  remove.runOnce();
}

void StateTableWriter::removeOthers() {
  SqliteStatement remove(database_, "DELETE FROM chunk WHERE state = ? AND name = ? AND kind = ?");
  for (auto it = written_.begin(); it != written_.end();) {
    if (seen_.count(it->first) > 0) {
      ++it;
      continue;
    }
    const std::string& key = it->first;
    const std::size_t first = key.find('\n');
    const std::size_t second = key.find('\n', first + 1);
    const std::string table = mapTableOf(key.substr(0, first));
    if (second == first + 1 && !table.empty()) {
      database_.run("DROP TABLE IF EXISTS " + quoted(table));
      columns_.erase(table);
    } else {
      remove.bind(1, key.substr(0, first));
      remove.bind(2, key.substr(first + 1, second - first - 1));
      remove.bind(3, key.substr(second + 1));
      remove.runOnce();
    }
    it = written_.erase(it);
  }
}

}  // namespace ratslam
