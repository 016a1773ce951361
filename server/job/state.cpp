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

constexpr std::array<std::pair<Event, std::string_view>, 3> events{
    {{Event::in_progress, "inProgress"}, {Event::success, "success"}, {Event::failed, "failed"}}};

using Phase = bake::Progress::Phase;
constexpr std::array<std::pair<Phase, std::string_view>, 4> phases{{{Phase::ingest, "ingest"},
                                                                    {Phase::tiles, "tiles"},
                                                                    {Phase::index, "index"},
                                                                    {Phase::done, "done"}}};

template <class Table, class Value>
std::string word_of(const Table& table, Value value) {
  for (const auto& row : table) {
    if (row.first == value) return std::string(row.second);
  }
  return {};
}
template <class Table>
auto value_of(const Table& table, std::string_view name) {
  for (const auto& row : table) {
    if (row.second == name) return row.first;
  }
  throw Error(Fault::bad_input, "", "\"" + std::string(name) + "\" is no known word");
}

json to_json(const Subscriber& subscriber) {
  return {{"success", subscriber.success},
          {"in_progress", subscriber.in_progress},
          {"failed", subscriber.failed}};
}

void read_into(const json& value, Job& job) {
  if (value.contains("subscriber")) {
    const auto& subscriber = value["subscriber"];
    subscriber.at("success").get_to(job.subscriber.success);
    subscriber.at("in_progress").get_to(job.subscriber.in_progress);
    subscriber.at("failed").get_to(job.subscriber.failed);
  }
  if (value.contains("outputs")) value["outputs"].get_to(job.outputs);
  if (value.contains("most_tiles")) job.bounds.tiles = value["most_tiles"].get<std::uint64_t>();
  if (value.contains("most_extent")) job.bounds.extent = value["most_extent"].get<double>();
  auto& outcome = job.outcome;
  value.at("warnings").get_to(outcome.warnings);
  value.at("complete").get_to(outcome.complete);
  outcome.progress = progress_from(value.at("progress"));
  if (value.contains("fault")) job.fault = fault_of(value["fault"].get<std::string>());
  for (const auto& problem : value.at("problems")) {
    job.problems.push_back(
        {problem.at("where").get<std::string>(), problem.at("what").get<std::string>()});
  }
}

}  // namespace

std::string name_of(Event event) { return word_of(events, event); }
Event event_of(std::string_view name) { return value_of(events, name); }
std::string name_of(Status status) { return word_of(statuses, status); }
std::string name_of(Fault fault) { return word_of(faults, fault); }
Status status_of(std::string_view name) { return value_of(statuses, name); }
Fault fault_of(std::string_view name) { return value_of(faults, name); }

json to_json(const bake::FinishedTile& tile) {
  const auto& [low, high] = tile.box;
  return {{"tile", tile.key.text()},
          {"box", json::array({low.x, low.y, low.z, high.x, high.y, high.z})}};
}

bake::FinishedTile finished_from(const json& value) {
  const auto key = plan::Key::parse(value.at("tile").get<std::string>());
  const auto box = value.at("box").get<std::array<double, 6>>();
  if (!key) throw Error(Fault::bad_input, "", "tells of a tile that is none");
  return {*key, {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}}};
}

json to_json(const bake::Progress& progress) {
  json finished = json::array();
  for (const auto& tile : progress.finished) finished.push_back(to_json(tile));
  return {{"finished", std::move(finished)}, {"phase", word_of(phases, progress.phase)},
          {"ingest", progress.ingest},       {"done", progress.done},
          {"total", progress.total},         {"reused", progress.reused},
          {"cached", progress.cached},       {"triangles", progress.triangles},
          {"bytes", progress.bytes}};
}

bake::Progress progress_from(const json& value) {
  bake::Progress progress;
  try {
    progress.phase = value_of(phases, value.at("phase").get<std::string>());
    value.at("ingest").get_to(progress.ingest);
    value.at("done").get_to(progress.done);
    value.at("total").get_to(progress.total);
    value.at("reused").get_to(progress.reused);
    value.at("cached").get_to(progress.cached);
    value.at("triangles").get_to(progress.triangles);
    value.at("bytes").get_to(progress.bytes);
    if (const auto found = value.find("finished"); found != value.end()) {
      for (const auto& tile : *found) progress.finished.push_back(finished_from(tile));
    }
  } catch (const json::exception& error) {
    throw Error(Fault::bad_input, "", error.what());
  }
  return progress;
}

std::string to_text(const Job& job) {
  json problems = json::array();
  for (const auto& problem : job.problems) {
    problems.push_back({{"where", problem.where}, {"what", problem.what}});
  }
  json value{{"warnings", job.outcome.warnings},
             {"complete", job.outcome.complete},
             {"progress", to_json(job.outcome.progress)},
             {"problems", problems}};
  if (!job.outputs.empty()) value["outputs"] = job.outputs;
  if (job.fault) value["fault"] = name_of(*job.fault);
  if (!job.subscriber.empty()) value["subscriber"] = to_json(job.subscriber);
  if (job.bounds.tiles) value["most_tiles"] = *job.bounds.tiles;
  if (job.bounds.extent) value["most_extent"] = *job.bounds.extent;
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

void read_text(std::string_view text, Job& job) {
  job.outcome = {};
  job.fault.reset();
  job.problems.clear();
  job.subscriber = {};
  job.bounds = {};
  job.outputs.clear();
  try {
    read_into(parse_json(text, "the state of a job"), job);
  } catch (const std::exception&) {
    job.outcome = {};
    job.status = Status::failed;
    job.fault = Fault::internal;
    job.problems = {{"", "the state of this job is damaged"}};
  }
}

}  // namespace hoodoo::job
