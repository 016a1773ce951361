#include <fmt/core.h>

#include <charconv>
#include <chrono>
#include <nlohmann/json.hpp>

#include "server/http/api.hpp"
#include "server/http/documents.hpp"
#include "server/http/files.hpp"
#include "server/http/problem.hpp"
#include "server/http/processes.hpp"
#include "server/http/query.hpp"
#include "server/http/turn.hpp"
#include "server/job/state.hpp"
#include "tiling/archive/archive.hpp"

/// The routes of jobs.
namespace hoodoo::http {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::string_view archive_name = "tileset.3tz";
constexpr auto heartbeat = std::chrono::seconds(15);  // keeps proxies from closing

Response no_job() {
  return problem(404, "There is no such job.", {}, std::string(problem_types) + "no-such-job");
}

Response redirect(const std::string& target) {
  Response response;
  response.status = 303;
  response.headers = {{"Location", target}, {"Cache-Control", "no-cache"}};
  return response;
}

/// Changes whenever what can be seen of the job does.
std::uint64_t revision(job::Time time) {
  return static_cast<std::uint64_t>(time.time_since_epoch().count());
}
std::uint64_t revision(const job::Job& job) { return revision(job.updated); }
std::string etag_of(const job::Job& job) {
  return fmt::format("\"{}{:x}\"", job.id, revision(job));
}

/// Tiles that were finished after the event of this id; all that are remembered where it is none.
json tiles_since(const job::Job& job, std::string_view event_id) {
  std::uint64_t known = 0;
  std::from_chars(event_id.data(), event_id.data() + event_id.size(), known);
  json tiles = json::array();
  if (!job.newest) return tiles;
  for (const auto& [tile, when] : *job.newest) {
    if (revision(when) > known) tiles.push_back(job::to_json(tile));
  }
  return tiles;
}

}  // namespace

Response Api::jobs(const Request& request, const Parameters&) {
  job::Filter filter;
  Query query;
  try {
    query = parse_query(request.query);
    filter = filter_of(query);
  } catch (const Error& error) {
    return problem(400, "The parameters are wrong.", in_query(error.problems));
  }
  if (!request.all_owners) filter.owner = request.owner;
  const auto limit = filter.limit++;  // one more tells whether there is a next page
  auto found = queue_.list(filter);
  const bool more = found.size() > limit;
  if (more) found.pop_back();
  std::vector<json> all;
  for (const auto& job : found) all.push_back(info(job));
  const auto next = more ? next_page(query, found.back().serial) : std::string();
  return document(job_list(all, request.query, next, settings_.base));
}

/// With "Prefer: wait=N" the answer comes when the job has ended, or, where If-None-Match says what
/// is known, when it has changed; or else after N seconds.
Response Api::status(const Request& request, const Parameters& parameters) {
  const std::string id(parameters[0]);
  const std::string known(request.header("if-none-match"));
  const int wait = preferences_of(request).wait;
  const auto until = Clock::now() + std::chrono::seconds(wait);
  const auto look = [this, id, known, until](bool at_once) -> std::optional<Response> {
    const auto job = queue_.find(id);
    if (!job) return no_job();
    const auto etag = etag_of(*job);
    const bool waits = job::has_ended(job->status) ? false : known.empty() || lists(known, etag);
    if (waits && !at_once && Clock::now() < until) return std::nullopt;
    auto response = document(info(*job));
    response.headers.emplace_back("ETag", etag);
    if (lists(known, etag)) {
      response.status = 304;
      response.body.clear();
    }
    return response;
  };
  if (auto now = look(false)) return std::move(*now);
  Response response;
  response.later = [look, wait](bool at_once) {
    auto ready = look(at_once);
    if (ready) ready->headers.emplace_back("Preference-Applied", fmt::format("wait={}", wait));
    return ready;
  };
  return response;
}

/// Server-sent events: one for each change, each with the whole status, so that whoever comes back
/// with Last-Event-ID, after a restart too, misses nothing but what has been overtaken.
Response Api::events(const Request& request, const Parameters& parameters) {
  const std::string id(parameters[0]);
  if (!queue_.find(id)) return no_job();
  Response response;
  response.type = "text/event-stream";
  response.headers = {{"Cache-Control", "no-cache"}, {"X-Accel-Buffering", "no"}};
  struct State {
    std::string known;
    Clock::time_point said = Clock::now();
    bool ended = false;
  };
  const auto state = std::make_shared<State>();
  state->known = request.header("last-event-id");
  response.more = [this, id, state]() -> std::optional<std::string> {
    if (state->ended) return std::nullopt;
    const auto job = queue_.find(id);
    if (!job) return std::nullopt;
    const auto event_id = std::to_string(revision(*job));
    state->ended = job::has_ended(job->status);
    if (event_id == state->known) {
      if (Clock::now() - state->said < heartbeat) return "";
      state->said = Clock::now();
      return ": still here\n\n";
    }
    auto told = info(*job);
    if (auto tiles = tiles_since(*job, state->known); !tiles.empty()) {
      told["finishedTiles"] = std::move(tiles);
    }
    state->known = event_id;
    state->said = Clock::now();
    const auto text = told.dump(-1, ' ', false, json::error_handler_t::replace);
    return fmt::format("id: {}\nevent: {}\ndata: {}\n\n", event_id, state->ended ? "end" : "status",
                       text);
  };
  return response;
}

Response Api::dismiss(const Request& request, const Parameters& parameters) {
  const auto known = queue_.find(parameters[0]);
  if (known && !request.all_owners && known->owner != request.owner) {
    return problem(403, "The job belongs to another key.");
  }
  auto job = queue_.dismiss(parameters[0]);
  if (!job) return no_job();
  job->status = job::Status::dismissed;
  return document(info(*job));
}

Response Api::job_results(const Request&, const Parameters& parameters) {
  const auto job = queue_.find(parameters[0]);
  if (!job) return no_job();
  if (job->status != job::Status::successful) return unfinished(*job);
  return document(results_of(*job));
}

Response Api::one_result(const Request&, const Parameters& parameters) {
  auto job = queue_.find(parameters[0]);
  if (!job) return no_job();
  if (job->status != job::Status::successful) return unfinished(*job);
  const auto all = results_of(*job);
  const auto found = all.find(std::string(parameters[1]));
  if (found == all.end()) return problem(404, "There is no such result.");
  if (parameters[1] == "report") {
    if (job->process != job::bake_process) job->outcome.report = queue_.report(job->id);
    return document(report(*job));
  }
  if (parameters[1] == "echo") return document(*found);
  return redirect(found->at("href").get<std::string>());
}

Response Api::result_file(const Request& request, const Parameters& parameters) {
  const auto job = queue_.find(parameters[0]);
  if (!job) return no_job();
  if (job->process == job::bake_process) {
    return parameters[1] == archive_name ? archive(*job) : problem(404, "There is no such file.");
  }
  auto response =
      serve_file({queue_.results(job->id), {".tif", ".csv", ".html"}}, parameters[1], request);
  // A page made of somebody's names runs no script here.
  response.headers.emplace_back("Content-Security-Policy",
                                "sandbox; default-src 'none'; img-src data:; style-src "
                                "'unsafe-inline'");
  return response;
}

/// All of a finished bake, packed while it is sent.
Response Api::archive(const job::Job& job) {
  if (job.status != job::Status::successful) return unfinished(job);
  auto turn = std::make_shared<Turn>(archives_, std::chrono::milliseconds(0));
  if (!*turn) {
    auto busy = problem(503, "As many archives are sent as may be at once.");
    busy.headers.emplace_back("Retry-After", "10");
    return busy;
  }
  Response response;
  response.type = "application/vnd.maxar.archive.3tz+zip";
  response.headers = {
      {"Cache-Control", "no-cache"},
      {"Content-Disposition", fmt::format("attachment; filename=\"{}.3tz\"", job.id)}};
  const auto packing = std::make_shared<archive::Packing>(queue_.results(job.id));
  response.more = [packing, turn = std::move(turn)] { return packing->next(); };
  return response;
}

Response Api::tile(const Request& request, const Parameters& parameters) {
  // Files are there for as long as their job: the store is asked only where there is none.
  if (!job::is_id(parameters[0])) return no_job();
  auto response = serve_file({queue_.results(parameters[0]), {".json", ".glb", ".subtree"}},
                             parameters[1], request);
  return response.status == 404 && !queue_.find(parameters[0]) ? no_job() : response;
}

/// Of a job that was successful.
json Api::results_of(job::Job job) const {
  if (job.process == echo_process) job.outcome.report = queue_.report(job.id);
  return results(job, result_files(job, queue_.results(job.id)), settings_.base);
}

json Api::info(const job::Job& job) const { return status_info(job, visible(job), settings_.base); }

std::vector<Problem> Api::visible(const job::Job& job) const {
  if (!job.fault) return {};
  return shown(*job.fault, job.problems, settings_.hidden);
}

/// A failed job's results answer with the kind of its failure: OGC 18-062r2, 7.11.
Response Api::unfinished(const job::Job& job) const {
  if (job.status == job::Status::failed) {
    return problem(status_of(job.fault.value_or(Fault::internal), job.problems), "The job failed.",
                   visible(job));
  }
  if (job.status == job::Status::dismissed) return problem(409, "The job was cancelled.");
  return problem(404, "The job has not finished.", {},
                 std::string(problem_types) + "result-not-ready");
}

}  // namespace hoodoo::http
