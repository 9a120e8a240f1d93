/// C++ wrappers of SQLite's handles. Every failure is an exception that names the file.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace ratslam {

class SqliteDatabase {
 public:
  enum class Access { kRead, kWrite };

  SqliteDatabase(const std::string& path, Access access);

  /// Runs statements that return no rows.
  void run(const std::string& sql);
  std::int64_t number(const std::string& sql);
  /// Refuses the file: "FILE: WHAT".
  [[noreturn]] void fail(const std::string& what) const;
  /// Refuses the file with SQLite's last error message.
  [[noreturn]] void failWithReport(const std::string& doing) const;
  sqlite3* handle() const { return handle_.get(); }
  const std::string& path() const { return path_; }

 private:
  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
  };
  std::string path_;
  std::unique_ptr<sqlite3, Close> handle_;
};

class SqliteStatement {
 public:
  SqliteStatement(SqliteDatabase& database, const std::string& sql);

  void bind(int place, std::int64_t value);
  void bind(int place, double value);
  void bind(int place, const std::string& value);
  void bindBlob(int place, const std::uint8_t* bytes, std::size_t size);
  void bindNull(int place);

  /// @return whether there is a row
  bool step();
  /// Runs a statement that returns no row, and resets it for the next values.
  void runOnce();
  void reset() { sqlite3_reset(statement_.get()); }

  std::int64_t integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
  double real(int column) const { return sqlite3_column_double(statement_.get(), column); }
  bool isNull(int column) const { return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL; }
  std::string text(int column) const;
  std::vector<std::uint8_t> blob(int column) const;
  int columns() const { return sqlite3_column_count(statement_.get()); }
  std::string name(int column) const { return sqlite3_column_name(statement_.get(), column); }

 private:
  void check(int result);

  struct Finalise {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  SqliteDatabase& database_;
  std::unique_ptr<sqlite3_stmt, Finalise> statement_;
};

}  // namespace ratslam
