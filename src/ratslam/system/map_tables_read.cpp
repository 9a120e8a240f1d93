#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "map_columns.h"
#include "map_tables.h"

namespace ratslam {
namespace {

constexpr std::int64_t kLargestChunk = std::int64_t{1} << 20U;

StateShape shapeOf(const std::string& text) {
  StateShape shape;
  std::size_t position = 0;
  while (position < text.size()) {
    std::size_t used = 0;
    shape.push_back(std::stoull(text.substr(position), &used));
    position += used + 1;
  }
  return shape;
}

void appendNumber(const SqliteStatement& statement, int column, StateType type,
                  std::vector<std::uint8_t>& bytes) {
  const auto append = [&bytes](auto value) {
    const std::size_t position = bytes.size();
    bytes.resize(position + sizeof value);
    std::memcpy(bytes.data() + position, &value, sizeof value);
  };
  const std::int64_t integer = statement.integer(column);
  // SQLite stores NaN as NULL.
  const double real = statement.isNull(column) ? std::nan("") : statement.real(column);
  switch (type) {
    case StateType::kInt8:
      return append(static_cast<std::int8_t>(integer));
    case StateType::kUint8:
      return append(static_cast<std::uint8_t>(integer));
    case StateType::kInt16:
      return append(static_cast<std::int16_t>(integer));
    case StateType::kUint16:
      return append(static_cast<std::uint16_t>(integer));
    case StateType::kInt32:
      return append(static_cast<std::int32_t>(integer));
    case StateType::kUint32:
      return append(static_cast<std::uint32_t>(integer));
    case StateType::kInt64:
      return append(integer);
    case StateType::kUint64:
      return append(static_cast<std::uint64_t>(integer));
    case StateType::kFloat32:
      return append(static_cast<float>(real));
    case StateType::kFloat64:
      return append(real);
  }
}

StateType typeOf(SqliteDatabase& database, const std::string& name) {
  for (std::uint8_t i = 0; i <= static_cast<std::uint8_t>(StateType::kFloat64); ++i) {
    if (name == stateTypeName(static_cast<StateType>(i))) return static_cast<StateType>(i);
  }
  database.fail("it is damaged: there is no type of number '" + name + "'");
}

std::vector<std::uint8_t> decompressed(SqliteDatabase& database, const std::vector<std::uint8_t>& data,
                                       std::int64_t size) {
  if (size < 0 || size > kLargestChunk) database.fail("it is damaged: a chunk's size");
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  if (data.size() == bytes.size()) return data;
  auto got = static_cast<uLongf>(bytes.size());
  if (uncompress(bytes.data(), &got, data.data(), static_cast<uLong>(data.size())) != Z_OK ||
      got != bytes.size()) {
    database.fail("it is damaged: a chunk cannot be unpacked");
  }
  return bytes;
}

std::vector<std::uint8_t> readChunks(SqliteDatabase& database, SqliteStatement& statement,
                                     const std::string& path, const std::string& name,
                                     const std::string& kind) {
  std::vector<std::uint8_t> bytes;
  statement.reset();
  statement.bind(1, path);
  statement.bind(2, name);
  statement.bind(3, kind);
  for (std::int64_t number = 0; statement.step(); ++number) {
    if (statement.integer(0) != number) database.fail("it is damaged: a chunk of " + path + " is missing");
    const auto chunk = decompressed(database, statement.blob(2), statement.integer(1));
    bytes.insert(bytes.end(), chunk.begin(), chunk.end());
  }
  return bytes;
}

/// Fills the columns of a State from its SQL table.
void readRows(SqliteDatabase& database, const std::string& table, std::vector<StateArray*>& arrays,
              const std::vector<std::string>& names, std::uint64_t rows) {
  std::string list;
  for (const std::string& name : names) list += ", " + quoted(name);
  SqliteStatement statement(database, "SELECT row_id" + list + " FROM " + quoted(table) + " ORDER BY row_id");
  std::uint64_t row = 0;
  for (; statement.step(); ++row) {
    if (row >= rows || statement.integer(0) != static_cast<std::int64_t>(row)) {
      database.fail("it is damaged: rows of table " + table + " do not follow each other");
    }
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      StateArray& array = *arrays[i];
      if (isNumberColumn(array)) {
        appendNumber(statement, static_cast<int>(i) + 1, array.type, array.bytes);
        continue;
      }
      const std::vector<std::uint8_t> entry = statement.blob(static_cast<int>(i) + 1);
      array.bytes.insert(array.bytes.end(), entry.begin(), entry.end());
      if (array.shape.back() == 0) array.ends.push_back(array.bytes.size() / stateTypeSize(array.type));
    }
  }
  if (row != rows) database.fail("it is damaged: rows of table " + table + " are missing");
}

}  // namespace

State readStates(SqliteDatabase& database) {
  State root;
  SqliteStatement states(database, "SELECT path, row_count, sql_table FROM state ORDER BY path");
  SqliteStatement arrays(database,
                         "SELECT name, type, shape, ragged FROM array WHERE state = ? ORDER BY name");
  SqliteStatement chunks(
      database,
      "SELECT number, size, data FROM chunk WHERE state = ? AND name = ? AND kind = ? ORDER BY number");
  while (states.step()) {
    const std::string path = states.text(0);
    State* state = &root;
    for (std::size_t begin = 0; begin < path.size();) {
      const std::size_t end = std::min(path.find('/', begin), path.size());
      state = &state->child(path.substr(begin, end - begin));
      begin = end + 1;
    }
    if (!states.isNull(1)) state->setRows(static_cast<std::uint64_t>(states.integer(1)));
    const bool in_table = !states.isNull(2);
    std::vector<std::pair<std::string, StateArray>> read;
    arrays.reset();
    arrays.bind(1, path);
    while (arrays.step()) {
      StateArray array;
      array.type = typeOf(database, arrays.text(1));
      array.shape = shapeOf(arrays.text(2));
      const bool ragged = arrays.integer(3) != 0;
      const std::string name = arrays.text(0);
      if (!in_table) {
        array.bytes = readChunks(database, chunks, path, name, "numbers");
        if (ragged) {
          const std::vector<std::uint8_t> ends = readChunks(database, chunks, path, name, "ends");
          array.ends.resize(ends.size() / sizeof array.ends[0]);
          if (!array.ends.empty()) {
            std::memcpy(array.ends.data(), ends.data(), array.ends.size() * sizeof array.ends[0]);
          }
        }
      } else if (ragged) {
        array.shape.push_back(0);  // marks the column until its entries are known
      }
      read.emplace_back(name, std::move(array));
    }
    if (in_table && !read.empty()) {
      std::vector<StateArray*> columns;
      std::vector<std::string> names;
      for (auto& [name, array] : read) {
        columns.push_back(&array);
        names.push_back(name);
      }
      const std::string table = mapTableOf(path);
      if (table.empty()) database.fail("it is damaged: " + path + " has no table");
      readRows(database, table, columns, names, state->rows().value_or(0));
      for (auto& [name, array] : read) {
        if (array.shape.back() == 0) array.shape.pop_back();
      }
    }
    for (auto& [name, array] : read) state->setArray(name, std::move(array));
    if (state->rows().value_or(0) > 0 && state->arrays().empty()) {
      database.fail("it is damaged: " + path + " has rows and no columns");
    }
  }
  return root;
}

}  // namespace ratslam
