#include "server/job/state.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/json.hpp"

namespace hoodoo::job {
namespace {

using nlohmann::json;

constexpr std::array<std::pair<Status, std::string_view>, 5> statuses{
    {{Status::accepted, "accepted"},
     {Status::running, "running"},
     {Status::successful, "successful"},
     {Status::failed, "failed"},
     {Status::dismissed, "dismissed"}}};
constexpr std::array<std::pair<Fault, std::string_view>, 6> faults{{{Fault::bad_input, "bad_input"},
                                                                    {Fault::not_found, "not_found"},
                                                                    {Fault::limit, "limit"},
                                                                    {Fault::cancelled, "cancelled"},
                                                                    {Fault::io, "io"},
                                                                    {Fault::internal, "internal"}}};

template <class Table, class Value>
std::string name_of(const Table& table, Value value) {
  for (const auto& row : table) {
    if (row.first == value) return std::string(row.second);
  }
  return {};
}
template <class Table>
auto value_of(const Table& table, const std::string& name) {
  for (const auto& row : table) {
    if (row.second == name) return row.first;
  }
  throw Error(Fault::bad_input, "job.json", "holds the unknown word " + name);
}

json to_json(Time time) { return time.time_since_epoch().count(); }
Time time_from(const json& value) {
  return Time(std::chrono::milliseconds(value.get<std::int64_t>()));
}

json to_json(const bake::Progress& progress) {
  return {{"done", progress.done},           {"total", progress.total},
          {"reused", progress.reused},       {"cached", progress.cached},
          {"triangles", progress.triangles}, {"bytes", progress.bytes}};
}
bake::Progress progress_from(const json& value, Status status) {
  bake::Progress progress;
  value.at("done").get_to(progress.done);
  value.at("total").get_to(progress.total);
  value.at("reused").get_to(progress.reused);
  progress.cached = value.value("cached", std::uint64_t{0});
  value.at("triangles").get_to(progress.triangles);
  value.at("bytes").get_to(progress.bytes);
  if (status == Status::successful) {
    progress.phase = bake::Progress::Phase::done;
    progress.ingest = 1;
  }
  return progress;
}

void read_into(Job& job, const json& value) {
  job.status = value_of(statuses, value.at("status").get<std::string>());
  if (job.status == Status::running) job.status = Status::accepted;
  value.at("serial").get_to(job.serial);
  value.at("name").get_to(job.name);
  job.created = time_from(value.at("created"));
  job.updated = time_from(value.at("updated"));
  if (value.contains("started")) job.started = time_from(value["started"]);
  if (value.contains("finished")) job.finished = time_from(value["finished"]);
  value.at("warnings").get_to(job.warnings);
  value.at("complete").get_to(job.complete);
  job.progress = progress_from(value.at("progress"), job.status);
  if (value.contains("fault")) job.fault = value_of(faults, value["fault"].get<std::string>());
  for (const auto& problem : value.at("problems")) {
    job.problems.push_back(
        {problem.at("where").get<std::string>(), problem.at("what").get<std::string>()});
  }
}

}  // namespace

std::string to_text(const Job& job) {
  json problems = json::array();
  for (const auto& problem : job.problems) {
    problems.push_back({{"where", problem.where}, {"what", problem.what}});
  }
  json value{{"status", name_of(statuses, job.status)},
             {"serial", job.serial},
             {"name", job.name},
             {"created", to_json(job.created)},
             {"updated", to_json(job.updated)},
             {"warnings", job.warnings},
             {"complete", job.complete},
             {"progress", to_json(job.progress)},
             {"problems", problems}};
  if (job.started) value["started"] = to_json(*job.started);
  if (job.finished) value["finished"] = to_json(*job.finished);
  if (job.fault) value["fault"] = name_of(faults, *job.fault);
  return value.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

Job from_text(std::string id, std::string_view text) {
  Job job;
  job.id = id;
  try {
    read_into(job, parse_json(text, "job.json"));
  } catch (const std::exception&) {
    job = Job{};
    job.id = std::move(id);
    job.status = Status::failed;
    job.fault = Fault::internal;
    job.problems = {{"", "the state of this job is damaged"}};
  }
  return job;
}

}  // namespace hoodoo::job
