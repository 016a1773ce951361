#include "server/job/database.hpp"
#include "server/job/state.hpp"
#include "server/job/store.hpp"

/// The callbacks that are owed.
namespace hoodoo::job {

std::string id_of(const Delivery& delivery) { return delivery.job + "-" + name_of(delivery.event); }

/// A job that is begun again after a restart has told so before.
void Store::add(const Delivery& owed) {
  Statement row(*database_,
                "INSERT OR IGNORE INTO deliveries (job, event, uri, body, tries, due) "
                "VALUES (?, ?, ?, ?, ?, ?)");
  row.bind(owed.job).bind(name_of(owed.event)).bind(owed.uri).bind(owed.body);
  row.bind(std::int64_t{owed.tries}).bind(milliseconds(owed.due)).step();
}

std::string host_of(std::string_view uri) {
  constexpr std::string_view end_of_scheme = "://";
  const auto scheme = uri.find(end_of_scheme);
  if (scheme != uri.npos) uri.remove_prefix(scheme + end_of_scheme.size());
  std::string host(uri.substr(0, uri.find_first_of("/?#")));
  for (auto& c : host) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return host;
}

std::optional<Delivery> Store::first_delivery(const std::set<std::string>& left_out) const {
  Statement rows(*database_,
                 "SELECT serial, uri FROM deliveries WHERE due IS NOT NULL ORDER BY due, serial");
  bool found = false;
  while (!found && rows.step()) found = !left_out.contains(host_of(rows.text(1)));
  if (!found) return std::nullopt;
  Statement row(*database_,
                "SELECT job, event, uri, body, tries, due FROM deliveries WHERE serial = ?");
  if (!row.bind(rows.number(0)).step()) return std::nullopt;
  return Delivery{row.text(0), event_of(row.text(1)),           row.text(2),
                  row.text(3), static_cast<int>(row.number(4)), row.time(5).value_or(Time{})};
}

std::size_t Store::count_deliveries() const {
  Statement row(*database_, "SELECT count(*) FROM deliveries WHERE due IS NOT NULL");
  row.step();
  return static_cast<std::size_t>(row.number(0));
}

/// What is settled needs no body, but stays, so that it is not owed again.
void Store::tried(const Delivery& delivery, std::optional<Time> again) {
  Statement row(*database_,
                "UPDATE deliveries SET tries = ?, due = ?, body = iif(?2 IS NULL, '', body) "
                "WHERE job = ? AND event = ? AND due IS NOT NULL");
  row.bind(std::int64_t{delivery.tries} + 1).bind(milliseconds(again));
  row.bind(delivery.job).bind(name_of(delivery.event)).step();
}

void Store::drop_deliveries(std::optional<std::string_view> job) {
  Statement row(*database_, std::string("UPDATE deliveries SET due = NULL, body = '' "
                                        "WHERE due IS NOT NULL") +
                                (job ? " AND job = ?" : ""));
  if (job) row.bind(*job);
  row.step();
}

}  // namespace hoodoo::job
