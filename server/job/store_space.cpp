#include "server/job/database.hpp"
#include "server/job/store.hpp"

/// What jobs and assets take on the disk, and which asset is whose.
namespace hoodoo::job {

void Store::set_bytes(std::string_view job, std::uint64_t bytes) {
  Statement row(*database_,
                "UPDATE jobs SET bytes = ?1 + coalesce((SELECT length(text) FROM reports WHERE "
                "job = ?2), 0) WHERE id = ?2");
  row.bind(static_cast<std::int64_t>(bytes)).bind(job).step();
}

std::vector<std::string> Store::uncounted() const {
  Statement rows(*database_,
                 "SELECT id FROM jobs WHERE bytes IS NULL AND status NOT IN "
                 "('accepted', 'running')");
  std::vector<std::string> ids;
  while (rows.step()) ids.push_back(rows.text(0));
  return ids;
}

std::uint64_t Store::bytes_of(std::string_view owner) const {
  Statement row(*database_,
                "SELECT (SELECT coalesce(sum(bytes), 0) FROM jobs WHERE owner = ?1) + "
                "(SELECT coalesce(sum(bytes), 0) FROM assets WHERE owner = ?1)");
  row.bind(owner).step();
  return static_cast<std::uint64_t>(row.number(0));
}

void Store::add_asset(const std::string& name, const std::string& owner, std::uint64_t bytes,
                      Time now) {
  Statement row(*database_, "INSERT OR IGNORE INTO assets VALUES (?, ?, ?, ?)");
  row.bind(name).bind(owner).bind(static_cast<std::int64_t>(bytes)).bind(milliseconds(now)).step();
}

void Store::remove_asset(std::string_view name) {
  Statement(*database_, "DELETE FROM assets WHERE name = ?").bind(name).step();
}

std::optional<std::string> Store::owner_of(std::string_view asset) const {
  Statement row(*database_, "SELECT owner FROM assets WHERE name = ?");
  if (!row.bind(asset).step()) return std::nullopt;
  return row.text(0);
}

std::optional<Time> Store::last_use(std::string_view asset) const {
  Statement row(*database_, "SELECT used FROM assets WHERE name = ?");
  if (!row.bind(asset).step()) return std::nullopt;
  return row.time(0);
}

std::vector<std::string> Store::assets() const {
  Statement rows(*database_, "SELECT name FROM assets");
  std::vector<std::string> names;
  while (rows.step()) names.push_back(rows.text(0));
  return names;
}

bool Store::is_used(std::string_view asset) const {
  Statement row(*database_,
                "SELECT 1 FROM uses JOIN jobs ON jobs.id = uses.job WHERE uses.asset = ? AND "
                "jobs.status IN ('accepted', 'running') LIMIT 1");
  return row.bind(asset).step();
}

void Store::note_use(std::string_view job, Time now) {
  Statement row(*database_,
                "UPDATE assets SET used = ? WHERE name IN (SELECT asset FROM uses WHERE job = ?)");
  row.bind(milliseconds(now)).bind(job).step();
}

}  // namespace hoodoo::job
