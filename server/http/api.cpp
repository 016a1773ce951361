#include "server/http/api.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/base/json.hpp"
#include "server/http/documents.hpp"
#include "server/http/files.hpp"
#include "server/http/problem.hpp"

namespace hoodoo::http {
namespace {

using nlohmann::json;

constexpr const char* problem_types =
    "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/";

Response document(const json& value, int status = 200) {
  Response response;
  response.status = status;
  response.type = "application/json";
  response.headers = {{"Cache-Control", "no-store"}};
  response.body = value.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
  return response;
}

Response redirect(int status, const std::string& target) {
  Response response;
  response.status = status;
  response.headers = {{"Location", target}};
  return response;
}

Response no_job() {
  return problem(404, "There is no such job.", {}, std::string(problem_types) + "no-such-job");
}

/// The parameters when `path` fits `pattern`.
std::optional<std::vector<std::string_view>> match(std::string_view pattern,
                                                   std::string_view path) {
  std::vector<std::string_view> parameters;
  const auto cut = [](std::string_view& text) {
    const auto slash = text.find('/');
    const auto segment = text.substr(0, slash);
    text = slash == text.npos ? std::string_view() : text.substr(slash + 1);
    return std::pair(segment, slash == text.npos);
  };
  for (;;) {
    if (pattern == "**") {
      parameters.push_back(path);
      return parameters;
    }
    const auto [wanted, pattern_ends] = cut(pattern);
    const auto [segment, path_ends] = cut(path);
    if (wanted == "*" && !segment.empty()) {
      parameters.push_back(segment);
    } else if (wanted != segment) {
      return std::nullopt;
    }
    if (pattern_ends != path_ends) return std::nullopt;
    if (pattern_ends) return parameters;
  }
}

/// Any page may read what belongs to one job: whoever knows its id was given it. A finished tileset
/// is there for viewers anywhere.
bool is_open_to_pages(std::string_view path) {
  return path.starts_with("/jobs/") || path.starts_with("/tilesets/");
}

json scene_of(const Request& request) {
  JsonLimits limits;
  limits.bytes = most_body;
  limits.values = 1'000'000;
  auto body = parse_json(request.body, "", limits);
  const auto refuse = [](const char* pointer, const char* what) {
    throw Error(Fault::bad_input, pointer, what);
  };
  if (!body.is_object()) refuse("", "must be an object");
  if (body.contains("subscriber")) refuse("/subscriber", "callbacks are not offered");
  if (body.value("response", json("document")) != "document") {
    refuse("/response", "must be \"document\": results are given by reference");
  }
  if (!body.contains("inputs")) refuse("/inputs", "is missing");
  if (!body["inputs"].is_object()) refuse("/inputs", "must be an object");
  for (const auto& [key, value] : body["inputs"].items()) {
    if (key != "scene") refuse("/inputs", "takes \"scene\" and nothing else");
  }
  if (!body["inputs"].contains("scene")) refuse("/inputs/scene", "is missing");
  if (!body["inputs"]["scene"].is_object()) refuse("/inputs/scene", "must be an object");
  return std::move(body["inputs"]["scene"]);
}

}  // namespace

Api::Api(job::Queue& queue, ApiSettings settings) : queue_(queue), settings_(std::move(settings)) {}

const std::vector<Api::Route>& Api::routes() {
  static const std::vector<Route> all{{"GET", "", &Api::landing},
                                      {"GET", "conformance", &Api::conforms},
                                      {"GET", "processes", &Api::processes},
                                      {"GET", "processes/*", &Api::process},
                                      {"POST", "processes/*/execution", &Api::execute},
                                      {"GET", "jobs", &Api::jobs},
                                      {"GET", "jobs/*", &Api::status},
                                      {"DELETE", "jobs/*", &Api::dismiss},
                                      {"GET", "jobs/*/results", &Api::job_results},
                                      {"GET", "jobs/*/results/*", &Api::one_result},
                                      {"GET", "jobs/*/tiles/**", &Api::tile},
                                      {"GET", "tilesets", &Api::tilesets},
                                      {"GET", "tilesets/*/**", &Api::tileset_file},
                                      {"GET", "viewer", &Api::viewer_folder},
                                      {"GET", "viewer/**", &Api::viewer},
                                      {"GET", "healthz", &Api::health}};
  return all;
}

Response Api::answer(const Request& request) {
  Response response;
  try {
    response = route(request);
  } catch (const Error& error) {
    const auto seen = shown(error.fault, error.problems, settings_.hidden);
    response = problem(status_of(error.fault), "The request could not be carried out.", seen);
    if (status_of(error.fault) >= 500) fmt::print(stderr, "hoodoo: {}\n", error.what());
  } catch (const std::exception& error) {
    fmt::print(stderr, "hoodoo: internal error: {}\n", error.what());
    response = problem(500, "internal error");
  }
  response.headers.emplace_back("X-Content-Type-Options", "nosniff");
  if (is_open_to_pages(request.path)) {
    response.headers.emplace_back("Access-Control-Allow-Origin", "*");
    response.headers.emplace_back("Access-Control-Expose-Headers",
                                  "ETag, Content-Range, Content-Length, Accept-Ranges");
  }
  return response;
}

Response Api::route(const Request& request) {
  const auto& hosts = settings_.hosts;
  if (!hosts.empty() && std::ranges::find(hosts, request.header("host")) == hosts.end()) {
    return problem(421, "This server does not answer for that host; see --public-url.");
  }
  if (request.path.size() > most_path) return problem(414, "The path is too long.");
  std::string_view path = request.path;
  if (!path.starts_with('/')) return problem(404, "There is nothing at this path.");
  path.remove_prefix(1);
  std::string_view method = request.method;
  if (method == "HEAD") method = "GET";
  std::string allowed;
  for (const auto& candidate : routes()) {
    const auto parameters = match(candidate.pattern, path);
    if (!parameters) continue;
    if (candidate.method == method) return (this->*candidate.handler)(request, *parameters);
    allowed += std::string(allowed.empty() ? "" : ", ") + std::string(candidate.method);
    if (candidate.method == "GET") allowed += ", HEAD";
  }
  if (allowed.empty()) return problem(404, "There is nothing at this path.");
  allowed += ", OPTIONS";
  if (method == "OPTIONS") {
    Response response;
    response.status = 204;
    response.headers = {{"Allow", allowed}};
    if (is_open_to_pages(request.path)) {
      response.headers.emplace_back("Access-Control-Allow-Methods", "GET, HEAD");
      response.headers.emplace_back("Access-Control-Allow-Headers",
                                    "Range, If-None-Match, If-Range");
      response.headers.emplace_back("Access-Control-Max-Age", "86400");
    }
    return response;
  }
  auto response = problem(405, "This path takes " + allowed + ".");
  response.headers.emplace_back("Allow", allowed);
  return response;
}

Response Api::landing(const Request&, const Parameters&) {
  return document(landing_page(settings_.base));
}
Response Api::conforms(const Request&, const Parameters&) { return document(conformance()); }
Response Api::health(const Request&, const Parameters&) { return document({{"status", "ok"}}); }
Response Api::processes(const Request&, const Parameters&) {
  return document(process_list(settings_.base));
}

Response Api::process(const Request&, const Parameters& parameters) {
  if (parameters[0] != bake_process) {
    return problem(404, "There is no such process.", {},
                   std::string(problem_types) + "no-such-process");
  }
  return document(process_description(settings_.base, settings_.scene_schema()));
}

Response Api::execute(const Request& request, const Parameters& parameters) {
  if (parameters[0] != bake_process) return process(request, parameters);
  // A page of another origin can send this type only after a preflight, which is refused.
  if (!request.header("content-type").starts_with("application/json")) {
    return problem(415, "Send the job as application/json.");
  }
  json scene;
  try {
    scene = scene_of(request);
  } catch (const Error& error) {
    return problem(error.fault == Fault::limit ? 413 : 400,
                   "The body must be {\"inputs\": {\"scene\": {...}}}.", error.problems);
  }
  std::optional<job::Job> job;
  try {
    job = queue_.submit(scene);
  } catch (const Error& error) {
    if (error.fault != Fault::bad_input) throw;
    return problem(422, "The scene has problems.",
                   shown(error.fault, error.problems, settings_.hidden));
  }
  if (!job) {
    auto refusal = problem(429, "Too many jobs are waiting.");
    refusal.headers.emplace_back("Retry-After", "60");
    return refusal;
  }
  auto response = document(info(*job), 201);
  response.headers.emplace_back("Location", settings_.base + "/jobs/" + job->id);
  response.headers.emplace_back("Preference-Applied", "respond-async");
  return response;
}

Response Api::jobs(const Request&, const Parameters&) {
  std::vector<json> all;
  for (const auto& job : queue_.list()) all.push_back(info(job));
  return document(job_list(all, settings_.base));
}

Response Api::status(const Request&, const Parameters& parameters) {
  const auto job = queue_.find(parameters[0]);
  return job ? document(info(*job)) : no_job();
}

Response Api::dismiss(const Request&, const Parameters& parameters) {
  auto job = queue_.dismiss(parameters[0]);
  if (!job) return no_job();
  job->status = job::Status::dismissed;
  return document(info(*job));
}

Response Api::job_results(const Request&, const Parameters& parameters) {
  const auto job = queue_.find(parameters[0]);
  if (!job) return no_job();
  if (job->status != job::Status::successful) return unfinished(*job);
  return document(results(*job, settings_.base));
}

Response Api::one_result(const Request&, const Parameters& parameters) {
  const auto job = queue_.find(parameters[0]);
  if (!job) return no_job();
  const auto name = parameters[1];
  if (name != "report" && name != "tileset" && name != "manifest") {
    return problem(404, "There is no such result.");
  }
  if (job->status != job::Status::successful) return unfinished(*job);
  if (name == "report") return document(report(*job));
  const auto all = results(*job, settings_.base);
  return redirect(303, all.at(std::string(name)).at("href").get<std::string>());
}

Response Api::tile(const Request& request, const Parameters& parameters) {
  if (!queue_.find(parameters[0])) return no_job();
  return serve_file({queue_.tileset(parameters[0]), {".json", ".glb", ".subtree"}}, parameters[1],
                    request);
}

Response Api::tilesets(const Request&, const Parameters&) {
  return document(tileset_list(settings_.tilesets.names(), settings_.base));
}

Response Api::tileset_file(const Request& request, const Parameters& parameters) {
  return settings_.tilesets.serve(parameters[0], parameters[1], request);
}

Response Api::viewer_folder(const Request& request, const Parameters&) {
  return redirect(308,
                  settings_.base + "/viewer/" + (request.query.empty() ? "" : "?" + request.query));
}

Response Api::viewer(const Request& request, const Parameters& parameters) {
  if (settings_.viewer.empty()) return problem(404, "The viewer is not installed.");
  const auto name = parameters[0].empty() ? std::string_view("index.html") : parameters[0];
  auto response = serve_file({settings_.viewer, {".html", ".css", ".js", ".json", ".wasm", ".svg"}},
                             name, request);
  // What a page may load stands in the page itself; these a page cannot set.
  response.headers.emplace_back("Content-Security-Policy",
                                "frame-ancestors 'none'; base-uri 'none'; form-action 'none'");
  response.headers.emplace_back("Referrer-Policy", "no-referrer");
  return response;
}

json Api::info(const job::Job& job) const { return status_info(job, visible(job), settings_.base); }

std::vector<Problem> Api::visible(const job::Job& job) const {
  if (!job.fault) return {};
  return shown(*job.fault, job.problems, settings_.hidden);
}

/// A failed job's results answer with the kind of its failure: OGC 18-062r2, 7.11.
Response Api::unfinished(const job::Job& job) const {
  if (job.status == job::Status::failed) {
    return problem(status_of(job.fault.value_or(Fault::internal)), "The job failed.", visible(job));
  }
  if (job.status == job::Status::dismissed) return problem(409, "The job was cancelled.");
  return problem(404, "The job has not finished.", {},
                 std::string(problem_types) + "result-not-ready");
}

}  // namespace hoodoo::http
