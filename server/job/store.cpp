#include "server/job/store.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/error.hpp"
#include "server/job/database.hpp"
#include "server/job/state.hpp"

namespace hoodoo::job {
namespace {

constexpr int schema_version = 3;

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
)";

/// What version 2 adds. `bytes` of a job is null until they have been counted; `due` of a delivery
/// is null once it is settled.
constexpr const char* schema_2 = R"(
ALTER TABLE jobs ADD COLUMN bytes INTEGER;
CREATE TABLE deliveries (
  serial INTEGER PRIMARY KEY AUTOINCREMENT,
  job TEXT NOT NULL,
  event TEXT NOT NULL,
  uri TEXT NOT NULL,
  body TEXT NOT NULL,
  tries INTEGER NOT NULL,
  due INTEGER,
  UNIQUE (job, event)
);
CREATE INDEX deliveries_by_turn ON deliveries (due, serial);
CREATE TABLE uses (
  job TEXT NOT NULL,
  asset TEXT NOT NULL,
  PRIMARY KEY (job, asset)
);
CREATE INDEX uses_by_asset ON uses (asset);
CREATE TABLE assets (
  name TEXT PRIMARY KEY,
  owner TEXT NOT NULL,
  bytes INTEGER NOT NULL,
  used INTEGER NOT NULL
);
PRAGMA user_version = 2;
)";

/// What version 3 changes: reports, which may be large, are kept apart from what lists read.
constexpr const char* schema_3 = R"(
CREATE TABLE reports (
  job TEXT PRIMARY KEY,
  text BLOB NOT NULL
);
INSERT INTO reports SELECT id, CAST(json_extract(state, '$.report') AS BLOB) FROM jobs
  WHERE CASE WHEN json_valid(state) THEN json_type(state, '$.report') = 'object' ELSE 0 END;
UPDATE jobs SET state = json_remove(state, '$.report') WHERE id IN (SELECT job FROM reports);
PRAGMA user_version = 3;
)";

constexpr const char* columns =
    "serial, id, status, process, owner, key, fingerprint, priority, name, created, updated, "
    "started, finished, state";

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
  if (filter.told) {
    sql += " AND NOT EXISTS (SELECT 1 FROM deliveries WHERE job = jobs.id AND due IS NOT NULL)";
  }
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
  const auto version = [this] {
    Statement row(*database_, "PRAGMA user_version");
    row.step();
    return row.number(0);
  }();
  if (version < 0 || version > schema_version) {
    throw Error(Fault::io, file.string(), "was written by another release");
  }
  Transaction transaction(*database_);
  if (version < 1) database_->execute(schema);
  if (version < 2) database_->execute(schema_2);
  if (version < 3) database_->execute(schema_3);
  transaction.commit();
  Statement sound(*database_, "PRAGMA quick_check(1)");
  if (!sound.step() || sound.text(0) != "ok") {
    throw Error(Fault::io, file.string(), "is damaged: " + sound.text(0));
  }
}

Store::~Store() = default;

bool Store::insert(Job& job, const std::vector<std::string>& assets) {
  Transaction transaction(*database_);
  if (!job.key.empty()) {
    Statement(*database_,
              "UPDATE jobs SET key = NULL WHERE owner = ? AND key = ? AND status IN ('failed', "
              "'dismissed')")
        .bind(job.owner)
        .bind(job.key)
        .step();
  }
  Statement row(*database_,
                "INSERT INTO jobs (id, status, process, owner, key, fingerprint, priority, name, "
                "created, updated, started, finished, state) VALUES " +
                    marks(13));
  row.bind(job.id).bind(name_of(job.status)).bind(job.process).bind(job.owner).bind_key(job.key);
  row.bind(job.fingerprint).bind(std::int64_t{job.priority}).bind(job.name);
  row.bind(milliseconds(job.created)).bind(milliseconds(job.updated));
  row.bind(milliseconds(job.started)).bind(milliseconds(job.finished)).bind(to_text(job));
  if (!row.insert()) return false;
  job.serial = static_cast<std::uint64_t>(sqlite3_last_insert_rowid(database_->handle));
  for (const auto& asset : assets) {
    Statement(*database_, "INSERT OR IGNORE INTO uses VALUES (?, ?)")
        .bind(job.id)
        .bind(asset)
        .step();
  }
  transaction.commit();
  return true;
}

void Store::update(const Job& job, const std::optional<Delivery>& owed) {
  Transaction transaction(*database_);
  Statement row(*database_,
                "UPDATE jobs SET status = ?, updated = ?, started = ?, finished = ?, state = ? "
                "WHERE id = ?");
  row.bind(name_of(job.status)).bind(milliseconds(job.updated)).bind(milliseconds(job.started));
  row.bind(milliseconds(job.finished)).bind(to_text(job)).bind(job.id).step();
  if (job.outcome.report) {
    Statement report(*database_, "INSERT OR REPLACE INTO reports VALUES (?, CAST(? AS BLOB))");
    const auto replace = nlohmann::json::error_handler_t::replace;
    report.bind(job.id).bind(job.outcome.report->dump(-1, ' ', false, replace)).step();
  }
  if (owed) add(*owed);
  if (job.status == Status::dismissed) drop_deliveries(job.id);
  if (has_ended(job.status)) note_use(job.id, job.updated);
  transaction.commit();
}

void Store::remove(std::string_view id) {
  Transaction transaction(*database_);
  for (const auto* sql : {"DELETE FROM jobs WHERE id = ?", "DELETE FROM deliveries WHERE job = ?",
                          "DELETE FROM uses WHERE job = ?", "DELETE FROM reports WHERE job = ?"}) {
    Statement(*database_, sql).bind(id).step();
  }
  transaction.commit();
}

void Store::interrupt_all() {
  database_->execute("UPDATE jobs SET status = 'accepted' WHERE status = 'running'");
}

std::optional<Job> Store::find(std::string_view id) const {
  Statement rows(*database_, fmt::format("SELECT {} FROM jobs WHERE id = ?", columns));
  return first_of(rows.bind(id));
}

std::optional<Job> Store::find_key(std::string_view owner, std::string_view key) const {
  Statement rows(*database_,
                 fmt::format("SELECT {} FROM jobs WHERE owner = ? AND key = ?", columns));
  return first_of(rows.bind(owner).bind(key));
}

std::optional<Job> Store::first_waiting() const {
  Statement rows(*database_, fmt::format("SELECT {} FROM jobs WHERE status = 'accepted' "
                                         "ORDER BY priority DESC, serial LIMIT 1",
                                         columns));
  return first_of(rows);
}

std::vector<Job> Store::list(const Filter& filter, Time now) const {
  Statement rows(*database_, fmt::format("SELECT {} FROM jobs{} ORDER BY serial DESC LIMIT ?",
                                         columns, where_of(filter)));
  bind(rows, filter, now);
  rows.bind(static_cast<std::int64_t>(filter.limit));
  std::vector<Job> jobs;
  while (rows.step()) jobs.push_back(job_of(rows));
  return jobs;
}

std::string Store::report(std::string_view id) const {
  Statement row(*database_, "SELECT text FROM reports WHERE job = ?");
  return row.bind(id).step() ? row.text(0) : std::string();
}

std::size_t Store::count(Status status, std::optional<std::string_view> owner) const {
  Statement rows(*database_, std::string("SELECT count(*) FROM jobs WHERE status = ?") +
                                 (owner ? " AND owner = ?" : ""));
  rows.bind(name_of(status));
  if (owner) rows.bind(*owner);
  rows.step();
  return static_cast<std::size_t>(rows.number(0));
}

}  // namespace hoodoo::job
