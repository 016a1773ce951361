#include "server/http/documents.hpp"

#include <fmt/chrono.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>

#include "server/http/files.hpp"
#include "server/http/problem.hpp"
#include "server/http/processes.hpp"
#include "server/job/state.hpp"

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
  const auto& progress = job.outcome.progress;
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
      return "Finished.";
    case job::Status::dismissed:
      return "Cancelled.";
    case job::Status::failed:
      return problems.empty() ? "Failed." : Error(Fault::internal, problems).what();
    case job::Status::running:
      break;
  }
  if (job.process != job::bake_process) return "Running.";
  switch (job.outcome.progress.phase) {
    case bake::Progress::Phase::ingest:
      return "Reading elevations.";
    case bake::Progress::Phase::tiles:
      return fmt::format(
          "Baking tiles: {} of {}{}.", job.outcome.progress.done, job.outcome.progress.total,
          job.seconds_left ? fmt::format(", about {} s left", *job.seconds_left) : std::string());
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
            link(base + "/api", "service-desc", "The API in OpenAPI 3.0",
                 "application/vnd.oai.openapi+json;version=3.0"),
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

json conformance(bool callbacks) {
  const std::string processes = "http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf/";
  json classes = json::array();
  for (const auto* name :
       {"core", "ogc-process-description", "json", "oas30", "job-list", "dismiss"}) {
    classes.push_back(processes + name);
  }
  if (callbacks) classes.push_back(processes + "callback");
  return {{"conformsTo", classes}};
}

json status_info(const job::Job& job, const std::vector<Problem>& problems,
                 const std::string& base) {
  const auto self = base + "/jobs/" + job.id;
  const auto& progress = job.outcome.progress;
  json info{{"processID", job.process},
            {"type", "process"},
            {"jobID", job.id},
            {"id", job.id},
            {"processingEntityType", "ogc-api-processes"},
            {"status", job::name_of(job.status)},
            {"message", message(job, problems)},
            {"progress", percent(job)},
            {"created", text(job.created)},
            {"updated", text(job.updated)},
            {"title", job.name},
            {"priority", job.priority},
            {"phase", text(progress.phase)},
            {"tiles",
             {{"done", progress.done},
              {"total", progress.total},
              {"reused", progress.reused},
              {"cached", progress.cached}}},
            {"triangles", progress.triangles},
            {"bytes", progress.bytes},
            {"links", json::array({link(self, "self", "This job")})}};
  if (job.process == job::bake_process) {
    info["links"].push_back(
        link(base + "/viewer/?job=" + job.id, "alternate", "The job in the viewer", "text/html"));
    // Indexed with the first tile.
    if (progress.done > 0) {
      info["links"].push_back(
          link(self + "/tiles/tileset.json", "preview", "The tileset as far as it is"));
    }
  }
  if (job.seconds_left) info["secondsLeft"] = *job.seconds_left;
  if (job.started) info["started"] = text(*job.started);
  if (job.finished) info["finished"] = text(*job.finished);
  if (!problems.empty()) info["errors"] = errors(problems);
  if (job.status == job::Status::successful) {
    info["links"].push_back(link(self + "/results", results_relation, "Results"));
  }
  return info;
}

json job_list(const std::vector<json>& jobs, const std::string& self, const std::string& next,
              const std::string& base) {
  json list{{"jobs", jobs},
            {"links", json::array({link(base + "/jobs" + (self.empty() ? "" : "?" + self), "self",
                                        "This list")})}};
  if (!next.empty()) {
    list["links"].push_back(link(base + "/jobs?" + next, "next", "Earlier jobs"));
  }
  return list;
}

namespace {

/// Everything that the job has made.
json all_results(const job::Job& job, const std::vector<std::string>& files,
                 const std::string& base) {
  const auto self = base + "/jobs/" + job.id;
  const auto reference = [](const std::string& href, const std::string& type) {
    return json{{"href", href}, {"type", type}};
  };
  const std::string plain = "application/json";
  if (job.process == job::bake_process) {
    return {{"tileset", reference(self + "/tiles/tileset.json", plain)},
            {"manifest", reference(self + "/tiles/bake.json", plain)},
            {"report", reference(self + "/results/report", plain)}};
  }
  if (job.process == echo_process) {
    if (!job.outcome.report) throw Error(Fault::not_found, "", "the job is gone");
    return {{"echo", job.outcome.report->at("echo")}};
  }
  json all{{"report", reference(self + "/results/report", plain)}};
  for (const auto& file : files) {
    const std::filesystem::path name(file);
    const auto output = job.process == job::diff_process ? "page" : name.stem().string();
    all[output] = reference(self + "/files/" + file, type_of(name.extension().string()));
  }
  return all;
}

}  // namespace

json results(const job::Job& job, const std::vector<std::string>& files, const std::string& base) {
  auto all = all_results(job, files, base);
  if (job.outputs.empty()) return all;
  json wanted = json::object();
  for (const auto& name : job.outputs) {
    if (all.contains(name)) wanted[name] = std::move(all[name]);
  }
  return wanted;
}

json report(const job::Job& job) {
  if (job.process != job::bake_process) {
    if (!job.outcome.report) throw Error(Fault::not_found, "", "the job is gone");
    return *job.outcome.report;
  }
  const auto& progress = job.outcome.progress;
  json report{{"engine", HOODOO_VERSION},
              {"scene", job.name},
              {"complete", job.outcome.complete},
              {"warnings", job.outcome.warnings},
              {"tiles",
               {{"done", progress.done}, {"reused", progress.reused}, {"cached", progress.cached}}},
              {"triangles", progress.triangles},
              {"bytes", progress.bytes}};
  if (job.started && job.finished) {
    report["seconds"] = static_cast<double>((*job.finished - *job.started).count()) / 1000;
  }
  return report;
}

std::vector<std::string> result_files(const job::Job& job, const std::filesystem::path& folder) {
  std::vector<std::string> names;
  if (job.process == job::bake_process) return names;
  std::error_code error;
  for (const auto& item : std::filesystem::directory_iterator(folder, error)) {
    names.push_back(item.path().filename());
  }
  std::ranges::sort(names);
  return names;
}

std::string announcement(const job::Job& job, const std::filesystem::path& folder,
                         const std::string& base, const std::vector<std::string>& hidden) {
  std::vector<Problem> problems;
  if (job.fault) problems = shown(*job.fault, job.problems, hidden);
  const auto body = job.status == job::Status::successful
                        ? results(job, result_files(job, folder), base)
                        : status_info(job, problems, base);
  return body.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace hoodoo::http
