#include "server/job/store.hpp"

#include <fmt/core.h>
#include <sqlite3.h>

#include <utility>

#include "engine/base/error.hpp"
#include "server/job/state.hpp"

namespace hoodoo::job {
namespace {

constexpr int schema_version = 1;

/// `key` is null where a request had none, so that the index does not compare it.
constexpr const char* schema = R"(
CREATE TABLE jobs (
  serial INTEGER PRIMARY KEY AUTOINCREMENT,
  id TEXT NOT NULL UNIQUE,
  status TEXT NOT NULL,
  process TEXT NOT NULL,
  owner TEXT NOT NULL,
  key TEXT,
  fingerprint TEXT NOT NULL,
  priority INTEGER NOT NULL,
  name TEXT NOT NULL,
  created INTEGER NOT NULL,
  updated INTEGER NOT NULL,
  started INTEGER,
  finished INTEGER,
  state TEXT NOT NULL
);
CREATE UNIQUE INDEX jobs_by_key ON jobs (owner, key);
CREATE INDEX jobs_by_turn ON jobs (status, priority DESC, serial);
PRAGMA user_version = 1;
)";

constexpr const char* columns =
    "serial, id, status, process, owner, key, fingerprint, priority, name, created, updated, "
    "started, finished, state";

std::int64_t milliseconds(Time time) { return time.time_since_epoch().count(); }
std::optional<std::int64_t> milliseconds(std::optional<Time> time) {
  if (!time) return std::nullopt;
  return milliseconds(*time);
}

}  // namespace

struct Store::Database {
  std::string name;
  sqlite3* handle = nullptr;

  explicit Database(const std::filesystem::path& file) : name(file.string()) {
    const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
    if (sqlite3_open_v2(name.c_str(), &handle, flags, nullptr) != SQLITE_OK) {
      const std::string why = handle != nullptr ? sqlite3_errmsg(handle) : "out of memory";
      sqlite3_close(handle);
      throw Error(Fault::io, name, why);
    }
  }
  ~Database() { sqlite3_close(handle); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  [[noreturn]] void fail() const { throw Error(Fault::io, name, sqlite3_errmsg(handle)); }
  void execute(const char* sql) const {
    if (sqlite3_exec(handle, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail();
  }
};

namespace {

/// One prepared statement with its values.
class Statement {
 public:
  Statement(sqlite3* database, const std::string& sql) : database_(database) {
    if (sqlite3_prepare_v2(database, sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK) fail();
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

/// The job of a row of `columns`.
Job job_of(const Statement& row) {
  Job job;
  job.serial = static_cast<std::uint64_t>(row.number(0));
  job.id = row.text(1);
  job.process = row.text(3);
  job.owner = row.text(4);
  job.key = row.text(5);
  job.fingerprint = row.text(6);
  job.priority = static_cast<int>(row.number(7));
  job.name = row.text(8);
  job.created = row.time(9).value_or(Time{});
  job.updated = row.time(10).value_or(Time{});
  job.started = row.time(11);
  job.finished = row.time(12);
  try {
    job.status = status_of(row.text(2));
    read_text(row.text(13), job);
  } catch (const Error&) {
    read_text("", job);
  }
  return job;
}

std::optional<Job> first_of(Statement& rows) {
  if (!rows.step()) return std::nullopt;
  return job_of(rows);
}

/// "(?, ?)" for that many values.
std::string marks(std::size_t count) {
  std::string text = "(";
  for (std::size_t i = 0; i < count; ++i) text += i == 0 ? "?" : ", ?";
  return text + ")";
}

/// The statement of a list, with its values bound in the order they stand in.
std::string where_of(const Filter& filter) {
  std::string sql = " WHERE 1";
  if (!filter.statuses.empty()) sql += " AND status IN " + marks(filter.statuses.size());
  if (!filter.processes.empty()) sql += " AND process IN " + marks(filter.processes.size());
  if (filter.owner) sql += " AND owner = ?";
  if (filter.from) sql += " AND created >= ?";
  if (filter.to) sql += " AND created <= ?";
  if (filter.before) sql += " AND serial < ?";
  if (filter.shortest) sql += " AND coalesce(finished, ?) - started >= ?";
  if (filter.longest) sql += " AND coalesce(finished, ?) - started <= ?";
  if (filter.ended_by) sql += " AND finished <= ?";
  return sql;
}

void bind(Statement& statement, const Filter& filter, Time now) {
  for (const auto status : filter.statuses) statement.bind(name_of(status));
  for (const auto& process : filter.processes) statement.bind(std::string_view(process));
  if (filter.owner) statement.bind(std::string_view(*filter.owner));
  if (filter.from) statement.bind(milliseconds(*filter.from));
  if (filter.to) statement.bind(milliseconds(*filter.to));
  if (filter.before) statement.bind(static_cast<std::int64_t>(*filter.before));
  if (filter.shortest) statement.bind(milliseconds(now)).bind(*filter.shortest);
  if (filter.longest) statement.bind(milliseconds(now)).bind(*filter.longest);
  if (filter.ended_by) statement.bind(milliseconds(*filter.ended_by));
}

}  // namespace

Store::Store(const std::filesystem::path& file) : database_(std::make_unique<Database>(file)) {
  database_->execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;");
  Statement version(database_->handle, "PRAGMA user_version");
  version.step();
  if (version.number(0) == 0) {
    database_->execute(fmt::format("BEGIN; {} COMMIT;", schema).c_str());
  } else if (version.number(0) != schema_version) {
    throw Error(Fault::io, file.string(), "was written by another release");
  }
  Statement sound(database_->handle, "PRAGMA quick_check(1)");
  if (!sound.step() || sound.text(0) != "ok") {
    throw Error(Fault::io, file.string(), "is damaged: " + sound.text(0));
  }
}

Store::~Store() = default;

bool Store::insert(Job& job) {
  Statement row(database_->handle,
                "INSERT INTO jobs (id, status, process, owner, key, fingerprint, priority, name, "
                "created, updated, started, finished, state) VALUES " +
                    marks(13));
  row.bind(job.id).bind(name_of(job.status)).bind(job.process).bind(job.owner).bind_key(job.key);
  row.bind(job.fingerprint).bind(std::int64_t{job.priority}).bind(job.name);
  row.bind(milliseconds(job.created)).bind(milliseconds(job.updated));
  row.bind(milliseconds(job.started)).bind(milliseconds(job.finished)).bind(to_text(job));
  if (!row.insert()) return false;
  job.serial = static_cast<std::uint64_t>(sqlite3_last_insert_rowid(database_->handle));
  return true;
}

void Store::update(const Job& job) {
  Statement row(database_->handle,
                "UPDATE jobs SET status = ?, updated = ?, started = ?, finished = ?, state = ? "
                "WHERE id = ?");
  row.bind(name_of(job.status)).bind(milliseconds(job.updated)).bind(milliseconds(job.started));
  row.bind(milliseconds(job.finished)).bind(to_text(job)).bind(job.id).step();
}

void Store::remove(std::string_view id) {
  Statement(database_->handle, "DELETE FROM jobs WHERE id = ?").bind(id).step();
}

void Store::interrupt_all() {
  database_->execute("UPDATE jobs SET status = 'accepted' WHERE status = 'running'");
}

std::optional<Job> Store::find(std::string_view id) const {
  Statement rows(database_->handle, fmt::format("SELECT {} FROM jobs WHERE id = ?", columns));
  return first_of(rows.bind(id));
}

std::optional<Job> Store::find_key(std::string_view owner, std::string_view key) const {
  Statement rows(database_->handle,
                 fmt::format("SELECT {} FROM jobs WHERE owner = ? AND key = ?", columns));
  return first_of(rows.bind(owner).bind(key));
}

std::optional<Job> Store::first_waiting() const {
  Statement rows(database_->handle, fmt::format("SELECT {} FROM jobs WHERE status = 'accepted' "
                                                "ORDER BY priority DESC, serial LIMIT 1",
                                                columns));
  return first_of(rows);
}

std::vector<Job> Store::list(const Filter& filter, Time now) const {
  Statement rows(
      database_->handle,
      fmt::format("SELECT {} FROM jobs{} ORDER BY serial DESC LIMIT ?", columns, where_of(filter)));
  bind(rows, filter, now);
  rows.bind(static_cast<std::int64_t>(filter.limit));
  std::vector<Job> jobs;
  while (rows.step()) jobs.push_back(job_of(rows));
  return jobs;
}

std::size_t Store::count(Status status, std::optional<std::string_view> owner) const {
  Statement rows(database_->handle, std::string("SELECT count(*) FROM jobs WHERE status = ?") +
                                        (owner ? " AND owner = ?" : ""));
  rows.bind(name_of(status));
  if (owner) rows.bind(*owner);
  rows.step();
  return static_cast<std::size_t>(rows.number(0));
}

}  // namespace hoodoo::job
