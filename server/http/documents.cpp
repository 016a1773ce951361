#include "server/http/documents.hpp"

#include <fmt/chrono.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace hoodoo::http {
namespace {

using nlohmann::json;

constexpr const char* results_relation = "http://www.opengis.net/def/rel/ogc/1.0/results";

json link(const std::string& href, const char* relation, const char* title,
          const char* type = "application/json") {
  return {{"href", href}, {"rel", relation}, {"type", type}, {"title", title}};
}

/// RFC 3339 in UTC.
std::string text(job::Time time) {
  const auto milliseconds = time.time_since_epoch().count();
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                     fmt::gmtime(static_cast<std::time_t>(milliseconds / 1000)),
                     milliseconds % 1000);
}

const char* text(job::Status status) {
  switch (status) {
    case job::Status::accepted:
      return "accepted";
    case job::Status::running:
      return "running";
    case job::Status::successful:
      return "successful";
    case job::Status::failed:
      return "failed";
    case job::Status::dismissed:
      return "dismissed";
  }
  return "";
}

const char* text(bake::Progress::Phase phase) {
  switch (phase) {
    case bake::Progress::Phase::ingest:
      return "ingest";
    case bake::Progress::Phase::tiles:
      return "tiles";
    case bake::Progress::Phase::index:
      return "index";
    case bake::Progress::Phase::done:
      return "done";
  }
  return "";
}

/// Reading the elevations counts as a tenth of the work, the tiles as nearly all the rest.
int percent(const job::Job& job) {
  if (job.status == job::Status::successful) return 100;
  const auto& progress = job.progress;
  const double tiles = progress.total == 0 ? 0
                                           : static_cast<double>(progress.done) /
                                                 static_cast<double>(progress.total);
  switch (progress.phase) {
    case bake::Progress::Phase::ingest:
      return static_cast<int>(10 * progress.ingest);
    case bake::Progress::Phase::tiles:
      return static_cast<int>(10 + 88 * tiles);
    default:
      return 99;
  }
}

std::string message(const job::Job& job, const std::vector<Problem>& problems) {
  switch (job.status) {
    case job::Status::accepted:
      return "Waiting for its turn.";
    case job::Status::successful:
      return "The tileset is finished.";
    case job::Status::dismissed:
      return "Cancelled.";
    case job::Status::failed:
      return problems.empty() ? "Failed." : Error(Fault::internal, problems).what();
    case job::Status::running:
      break;
  }
  switch (job.progress.phase) {
    case bake::Progress::Phase::ingest:
      return "Reading elevations.";
    case bake::Progress::Phase::tiles:
      return fmt::format("Baking tiles: {} of {}.", job.progress.done, job.progress.total);
    default:
      return "Writing the index.";
  }
}

json errors(const std::vector<Problem>& problems) {
  json list = json::array();
  for (const auto& problem : problems) {
    list.push_back({{"pointer", problem.where}, {"detail", problem.what}});
  }
  return list;
}

json process_summary(const std::string& base) {
  return {{"id", bake_process},
          {"title", "Bake terrain"},
          {"description",
           "Turns elevation models and a scene into glTF tiles with a 3D Tiles 1.1 index."},
          {"version", HOODOO_VERSION},
          {"jobControlOptions", {"async-execute", "dismiss"}},
          {"outputTransmission", {"reference"}},
          {"links",
           {link(base + "/processes/" + bake_process, "self", "The process in full"),
            link(base + "/processes/" + bake_process + "/execution",
                 "http://www.opengis.net/def/rel/ogc/1.0/execute", "POST a job here")}}};
}

json output(const char* title, const char* description) {
  return {{"title", title},
          {"description", description},
          {"schema", {{"type", "string"}, {"contentMediaType", "application/json"}}}};
}

}  // namespace

json landing_page(const std::string& base) {
  return {{"title", "hoodoo"},
          {"description", "Bakes terrain with real three-dimensional landforms."},
          {"links",
           {link(base + "/", "self", "This page"),
            link(base + "/conformance", "http://www.opengis.net/def/rel/ogc/1.0/conformance",
                 "What this service conforms to"),
            link(base + "/processes", "http://www.opengis.net/def/rel/ogc/1.0/processes",
                 "What this service can do"),
            link(base + "/jobs", "http://www.opengis.net/def/rel/ogc/1.0/job-list", "Jobs"),
            link(base + "/tilesets", "related", "Finished tilesets"),
            link(base + "/viewer/", "alternate", "The viewer", "text/html")}}};
}

json tileset_list(const std::vector<std::string>& names, const std::string& base) {
  json list = json::array();
  for (const auto& name : names) {
    const auto path = "/tilesets/" + name + "/tileset.json";
    list.push_back(
        {{"name", name}, {"href", base + path}, {"viewer", base + "/viewer/?tileset=" + path}});
  }
  return {{"tilesets", list}};
}

json conformance() { return {{"conformsTo", json::array()}}; }

json process_list(const std::string& base) {
  return {{"processes", {process_summary(base)}},
          {"links", {link(base + "/processes", "self", "This list")}}};
}

json process_description(const std::string& base, const json& scene_schema) {
  auto process = process_summary(base);
  process["inputs"]["scene"] = {
      {"title", "Scene"},
      {"description", "What to bake. Files are named below the folders this server was given."},
      {"minOccurs", 1},
      {"maxOccurs", 1},
      {"schema", scene_schema}};
  process["outputs"] = {
      {"tileset", output("Tileset", "tileset.json of 3D Tiles 1.1")},
      {"manifest", output("Manifest", "bake.json: every tile with its hashes and numbers")},
      {"report", output("Report", "Counts and warnings of the bake")}};
  return process;
}

json status_info(const job::Job& job, const std::vector<Problem>& problems,
                 const std::string& base) {
  const auto self = base + "/jobs/" + job.id;
  const auto& progress = job.progress;
  json info{
      {"processID", bake_process},
      {"type", "process"},
      {"jobID", job.id},
      {"status", text(job.status)},
      {"message", message(job, problems)},
      {"progress", percent(job)},
      {"created", text(job.created)},
      {"updated", text(job.updated)},
      {"title", job.name},
      {"phase", text(progress.phase)},
      {"tiles",
       {{"done", progress.done},
        {"total", progress.total},
        {"reused", progress.reused},
        {"cached", progress.cached}}},
      {"triangles", progress.triangles},
      {"bytes", progress.bytes},
      {"links",
       {link(self, "self", "This job"),
        link(self + "/tiles/tileset.json", "preview", "The tileset as far as it is"),
        link(base + "/viewer/?job=" + job.id, "alternate", "The job in the viewer", "text/html")}}};
  if (job.started) info["started"] = text(*job.started);
  if (job.finished) info["finished"] = text(*job.finished);
  if (!problems.empty()) info["errors"] = errors(problems);
  if (job.status == job::Status::successful) {
    info["links"].push_back(link(self + "/results", results_relation, "Results"));
  }
  return info;
}

json job_list(const std::vector<json>& jobs, const std::string& base) {
  return {{"jobs", jobs}, {"links", {link(base + "/jobs", "self", "This list")}}};
}

json results(const job::Job& job, const std::string& base) {
  const auto self = base + "/jobs/" + job.id;
  const auto reference = [](const std::string& href) {
    return json{{"href", href}, {"type", "application/json"}};
  };
  return {{"tileset", reference(self + "/tiles/tileset.json")},
          {"manifest", reference(self + "/tiles/bake.json")},
          {"report", reference(self + "/results/report")}};
}

json report(const job::Job& job) {
  const auto& progress = job.progress;
  json report{{"engine", HOODOO_VERSION},
              {"scene", job.name},
              {"complete", job.complete},
              {"warnings", job.warnings},
              {"tiles",
               {{"done", progress.done}, {"reused", progress.reused}, {"cached", progress.cached}}},
              {"triangles", progress.triangles},
              {"bytes", progress.bytes}};
  if (job.started && job.finished) {
    report["seconds"] = static_cast<double>((*job.finished - *job.started).count()) / 1000;
  }
  return report;
}

}  // namespace hoodoo::http
