#pragma once
#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/error.hpp"
#include "server/job/job.hpp"

/// SQLite, as the parts of the store use it.
namespace hoodoo::job {

inline std::int64_t milliseconds(Time time) { return time.time_since_epoch().count(); }
inline std::optional<std::int64_t> milliseconds(std::optional<Time> time) {
  if (!time) return std::nullopt;
  return milliseconds(*time);
}

/// An open file. Errors of all members: io.
struct Database {
  std::string name;
  sqlite3* handle = nullptr;

  explicit Database(const std::filesystem::path& file);
  ~Database() { sqlite3_close(handle); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  void execute(const char* sql) const;
};

/// What is done while this lives is there as a whole, once it is committed, or not at all.
class Transaction {
 public:
  explicit Transaction(const Database& database) : database_(database) {
    database_.execute("BEGIN IMMEDIATE");
  }
  ~Transaction() {
    if (!committed_) sqlite3_exec(database_.handle, "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit() {
    database_.execute("COMMIT");
    committed_ = true;
  }

 private:
  const Database& database_;
  bool committed_ = false;
};

/// One prepared statement with its values.
class Statement {
 public:
  Statement(const Database& database, const std::string& sql) : database_(database.handle) {
    if (sqlite3_prepare_v2(database_, sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK) fail();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(std::string_view text) {
    check(sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_TRANSIENT,
                              SQLITE_UTF8));
    return *this;
  }
  Statement& bind(std::int64_t value) {
    check(sqlite3_bind_int64(statement_, ++bound_, value));
    return *this;
  }
  Statement& bind(std::optional<std::int64_t> value) {
    if (value) return bind(*value);
    check(sqlite3_bind_null(statement_, ++bound_));
    return *this;
  }
  Statement& bind_key(const std::string& key) {
    if (!key.empty()) return bind(std::string_view(key));
    return bind(std::optional<std::int64_t>());
  }

  /// True while there is a row.
  bool step() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) fail();
    return code == SQLITE_ROW;
  }
  /// False when the row is there already.
  bool insert() {
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_CONSTRAINT) return false;
    if (code != SQLITE_DONE) fail();
    return true;
  }

  std::int64_t number(int column) const { return sqlite3_column_int64(statement_, column); }
  std::optional<Time> time(int column) const {
    if (sqlite3_column_type(statement_, column) == SQLITE_NULL) return std::nullopt;
    return Time(std::chrono::milliseconds(number(column)));
  }
  std::string text(int column) const {
    const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    const auto length = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
    return bytes == nullptr ? std::string() : std::string(bytes, length);
  }

 private:
  void check(int code) const {
    if (code != SQLITE_OK) fail();
  }
  [[noreturn]] void fail() const { throw Error(Fault::io, "jobs", sqlite3_errmsg(database_)); }

  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

}  // namespace hoodoo::job
