#include "sqlite.h"

#include <filesystem>

#include "ratslam/system/map_store.h"

namespace ratslam {

namespace fs = std::filesystem;

SqliteDatabase::SqliteDatabase(const std::string& path, Access access) : path_(path) {
  const bool write = access == Access::kWrite;
  std::error_code error;
  const fs::file_status there = fs::status(path, error);
  if (!write && !fs::exists(there)) fail("there is no such map file");
  if (fs::is_directory(there)) fail("it is a folder, no map file");
  if (fs::exists(there) && !fs::is_regular_file(there)) {  // opening a pipe would block
    fail("it is no regular file (a pipe or a device)");
  }
  sqlite3* opened = nullptr;
  // A save that was interrupted has left a journal. Whoever reads next undoes it, and must be allowed to write for that.
  const bool interrupted = fs::exists(path + "-journal", error);
  const int flags = write         ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE
                    : interrupted ? SQLITE_OPEN_READWRITE
                                  : SQLITE_OPEN_READONLY;
  const int result = sqlite3_open_v2(path.c_str(), &opened, flags, nullptr);
  handle_.reset(opened);
  if (result != SQLITE_OK) failWithReport(write ? "cannot open it for writing" : "cannot open it");
  // SQLite itself would notice only at the first save.
  if (write && sqlite3_db_readonly(handle_.get(), "main") == 1) fail("the file cannot be written");
  sqlite3_extended_result_codes(handle_.get(), 1);
  sqlite3_busy_timeout(handle_.get(), 2000);
  run("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON");
  if (write) run("PRAGMA journal_mode = DELETE; PRAGMA synchronous = FULL; PRAGMA foreign_keys = OFF");
}

void SqliteDatabase::run(const std::string& sql) {
  if (sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
    failWithReport("cannot use it");
  }
}

std::int64_t SqliteDatabase::number(const std::string& sql) {
  SqliteStatement statement(*this, sql);
  return statement.step() ? statement.integer(0) : 0;
}

void SqliteDatabase::fail(const std::string& what) const { throw std::runtime_error(path_ + ": " + what); }

void SqliteDatabase::failWithReport(const std::string& doing) const {
  const int code = handle_ ? sqlite3_errcode(handle_.get()) & 0xFF : SQLITE_NOMEM;
  if (handle_ && sqlite3_extended_errcode(handle_.get()) == SQLITE_IOERR_WRITE) {
    fail("it cannot grow, the disk is full or broken: the file is as it was before");
  }
  switch (code) {
    case SQLITE_NOTADB:
      fail("it is not a map file");
    case SQLITE_CORRUPT:
      fail("it is damaged: " + std::string(sqlite3_errmsg(handle_.get())));
    case SQLITE_FULL:
      fail("the disk is full: the file is as it was before");
    case SQLITE_READONLY:
      fail(std::string("the file or its folder cannot be written") +
           (fs::exists(path_ + "-journal") ? ", which is needed to undo a save that was interrupted" : ""));
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw MapBusy(path_ + ": another program writes to it");
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      throw MapUnread(path_ + ": " + doing + ": " + sqlite3_errmsg(handle_.get()));
    default:
      fail(doing + ": " + (handle_ ? sqlite3_errmsg(handle_.get()) : "out of memory"));
  }
}

SqliteStatement::SqliteStatement(SqliteDatabase& database, const std::string& sql) : database_(database) {
  sqlite3_stmt* prepared = nullptr;
  const int result = sqlite3_prepare_v2(database.handle(), sql.c_str(), -1, &prepared, nullptr);
  statement_.reset(prepared);
  check(result);
}

void SqliteStatement::check(int result) {
  if (result != SQLITE_OK && result != SQLITE_ROW && result != SQLITE_DONE) {
    database_.failWithReport("cannot use it");
  }
}

void SqliteStatement::bind(int place, std::int64_t value) {
  check(sqlite3_bind_int64(statement_.get(), place, value));
}
void SqliteStatement::bind(int place, double value) {
  check(sqlite3_bind_double(statement_.get(), place, value));
}
void SqliteStatement::bind(int place, const std::string& value) {
  check(sqlite3_bind_text(statement_.get(), place, value.data(), static_cast<int>(value.size()),
                          SQLITE_TRANSIENT));
}
void SqliteStatement::bindBlob(int place, const std::uint8_t* bytes, std::size_t size) {
  static const std::uint8_t nothing = 0;  // a null pointer would bind NULL instead of an empty blob
  check(sqlite3_bind_blob64(statement_.get(), place, bytes == nullptr ? &nothing : bytes, size,
                            SQLITE_TRANSIENT));
}
void SqliteStatement::bindNull(int place) { check(sqlite3_bind_null(statement_.get(), place)); }

bool SqliteStatement::step() {
  const int result = sqlite3_step(statement_.get());
  check(result);
  return result == SQLITE_ROW;
}

void SqliteStatement::runOnce() {
  step();
  reset();
}

std::string SqliteStatement::text(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_.get(), column);
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return text == nullptr ? std::string() : std::string(text, text + size);
}

std::vector<std::uint8_t> SqliteStatement::blob(int column) const {
  const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), column));
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return bytes == nullptr ? std::vector<std::uint8_t>() : std::vector<std::uint8_t>(bytes, bytes + size);
}

}  // namespace ratslam
