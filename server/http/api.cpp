#include "server/http/api.hpp"

#include <fmt/core.h>
#include <sys/random.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "engine/base/hash.hpp"
#include "server/http/documents.hpp"
#include "server/http/files.hpp"
#include "server/http/log.hpp"
#include "server/http/openapi.hpp"
#include "server/http/problem.hpp"
#include "server/http/processes.hpp"
#include "server/http/tokens.hpp"
#include "server/http/tus.hpp"

namespace hoodoo::http {
namespace {

using nlohmann::json;

Response redirect(int status, const std::string& target) {
  Response response;
  response.status = status;
  response.headers = {{"Location", target}};
  return response;
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

/// The client's own name of its request, where it is a plain one; else 64 random bits.
std::string request_id(std::string_view given) {
  if (is_plain_name(given) && given.size() <= 64) return std::string(given);
  std::uint64_t bits = 0;
  if (::getrandom(&bits, sizeof bits, 0) != sizeof bits) bits = 0;
  return fmt::format("{:016x}", bits);
}

bool is_usual(std::string_view method) {
  return method == "GET" || method == "HEAD" || method == "POST" || method == "PUT" ||
         method == "PATCH" || method == "DELETE" || method == "OPTIONS";
}

/// Whom a gateway asks for. Only one on this machine is believed.
std::string forwarded_for(const Request& request) {
  constexpr std::size_t most = 64;
  if (!request.peer.starts_with("127.") && request.peer != "::1") return {};
  const auto hops = request.header("x-forwarded-for");
  return std::string(trimmed(hops.substr(hops.rfind(',') + 1)).substr(0, most));
}

/// The id of the job that a request is about, or that it made.
std::string job_of(const Request& request, const Response& response) {
  constexpr std::string_view jobs = "/jobs/";
  std::string_view path = request.path;
  if (!path.starts_with(jobs)) path = response.header("Location");
  const auto at = path.find(jobs);
  if (at == path.npos) return {};
  path.remove_prefix(at + jobs.size());
  return std::string(path.substr(0, path.find('/')));
}

/// A document that has not changed need not be sent again: RFC 9110, 13.1.2.
void tag(const Request& request, Response& response) {
  const bool reading = request.method == "GET" || request.method == "HEAD";
  if (!reading || response.status != 200 || response.body.empty()) return;
  if (!response.header("ETag").empty() || response.header("Cache-Control") == "no-store") return;
  const auto etag = "\"" + sha256(response.body).hex().substr(0, 32) + "\"";
  response.headers.emplace_back("ETag", etag);
  if (!lists(request.header("if-none-match"), etag)) return;
  response.status = 304;
  response.body.clear();
}

}  // namespace

Response document(const json& value, int status) {
  Response response;
  response.status = status;
  response.type = "application/json";
  response.headers = {{"Cache-Control", "no-cache"}};
  response.body = value.dump(-1, ' ', false, json::error_handler_t::replace);
  // Lines and their indentation are for readers; deep in a large document they would be most of it.
  constexpr std::size_t most_readable = 64u << 10;
  if (response.body.size() < most_readable) {
    response.body = value.dump(2, ' ', false, json::error_handler_t::replace);
  }
  response.body += "\n";
  return response;
}

Api::Api(job::Queue& queue, asset::Assets& assets, asset::Uploads& uploads, ApiSettings settings)
    : queue_(queue), assets_(assets), uploads_(uploads), settings_(std::move(settings)) {}

bool Api::takes_body(const Request& head) {
  return (head.method == "PUT" && head.path.starts_with("/assets/")) || tus::is_path(head.path);
}

const std::vector<Api::Route>& Api::routes() {
  static const std::vector<Route> all{
      {"GET", "", &Api::landing},
      {"GET", "conformance", &Api::conforms},
      {"GET", "api", &Api::api_document},
      {"GET", "processes", &Api::processes},
      {"GET", "processes/*", &Api::process},
      {"POST", "processes/*/execution", &Api::execute, Scope::submit},
      {"GET", "jobs", &Api::jobs, Scope::read},
      {"GET", "jobs/*", &Api::status},
      {"DELETE", "jobs/*", &Api::dismiss, Scope::submit},
      {"GET", "jobs/*/results", &Api::job_results},
      {"GET", "jobs/*/results/*", &Api::one_result},
      {"GET", "jobs/*/events", &Api::events},
      {"GET", "jobs/*/files/*", &Api::result_file},
      {"GET", "jobs/*/tiles/**", &Api::tile},
      {"GET", "assets", &Api::asset_list, Scope::read},
      {"GET", "assets/*", &Api::asset, Scope::read},
      {"POST", "assets", &Api::fetch_asset, Scope::submit},
      {"PUT", "assets/*", &Api::put_asset, Scope::submit},
      {"DELETE", "assets/*", &Api::remove_asset, Scope::submit},
      {"POST", "uploads", &Api::create_upload, Scope::submit},
      {"HEAD", "uploads/*", &Api::upload_state, Scope::submit},
      {"PATCH", "uploads/*", &Api::add_to_upload, Scope::submit},
      {"DELETE", "uploads/*", &Api::remove_upload, Scope::submit},
      {"GET", "tilesets", &Api::tilesets, Scope::read},
      {"GET", "tilesets/*/**", &Api::tileset_file},
      {"GET", "viewer", &Api::viewer_folder},
      {"GET", "viewer/**", &Api::viewer},
      {"GET", "healthz", &Api::health},
      {"GET", "readyz", &Api::ready},
      {"GET", "metrics", &Api::metrics, Scope::admin}};
  return all;
}

Response Api::answer(Request request) {
  const auto from = Clock::now();
  request.id = request_id(request.header("x-request-id"));
  const auto id = request.id;
  std::string_view pattern = "none";
  const auto guarded = [this, id](const std::function<Response()>& make) {
    try {
      return make();
    } catch (const Error& error) {
      return of_error(error, id);
    } catch (const std::exception& error) {
      log_fault(std::string("internal error: ") + error.what(), id);
      return problem(500, "internal error");
    }
  };
  auto response = guarded([&] {
    auto refused = refusal_of_condition(request);
    return refused ? std::move(*refused) : route(request, pattern);
  });
  request.body.clear();
  const auto end = [this, request = std::move(request), pattern, from](Response& ready) {
    conclude(request, pattern, from, ready);
  };
  if (response.take) {
    response.take = [end, guarded, take = std::move(response.take)](const ReadBody& read) {
      auto ready = guarded([&] { return take(read); });
      end(ready);
      return ready;
    };
    return response;
  }
  if (response.later) {
    response.later = [end, guarded, later = std::move(response.later)](bool at_once) {
      std::optional<Response> ready;
      auto failed = guarded([&] {
        ready = later(at_once);
        return Response();
      });
      if (failed.status != 200) ready = std::move(failed);
      if (ready) end(*ready);
      return ready;
    };
    return response;
  }
  end(response);
  return response;
}

/// If-Match of what would change something: RFC 9110, 13.1.1. What is there now is what HEAD tells.
std::optional<Response> Api::refusal_of_condition(const Request& request) {
  const auto wanted = request.header("if-match");
  const bool reading = request.method == "GET" || request.method == "HEAD";
  if (wanted.empty() || reading || request.method == "OPTIONS") return std::nullopt;
  Request head;
  head.method = "HEAD";
  head.path = request.path;
  head.headers = request.headers;
  for (const auto* name : {"if-none-match", "prefer", "range"}) head.headers.erase(name);
  std::string_view pattern;
  auto now = route(head, pattern);
  tag(head, now);
  const auto etag = now.header("ETag");
  const bool is_meant = wanted == "*" || (!etag.empty() && lists(wanted, etag, Comparison::strong));
  if (now.status == 200 && is_meant) return std::nullopt;
  return problem(412, "What is there is not what If-Match says.");
}

void Api::conclude(const Request& request, std::string_view pattern, Clock::time_point since,
                   Response& response) {
  finish(request, response);
  response.headers.emplace_back("X-Request-Id", request.id);
  const std::chrono::duration<double> took = Clock::now() - since;
  metrics_.count(pattern, is_usual(request.method) ? request.method : "other", response.status,
                 took.count());
  log_request({request.id, request.method, request.path, request.peer, forwarded_for(request),
               job_of(request, response), request.owner, response.status, 1e3 * took.count()});
}

void Api::note(Request request, Response& response, Clock::time_point since) {
  request.id = request_id(request.header("x-request-id"));
  std::string_view pattern = "none";
  for (const auto& route : routes()) {
    if (request.path.starts_with('/') &&
        match(route.pattern, std::string_view(request.path).substr(1))) {
      pattern = route.pattern;
    }
  }
  conclude(request, pattern, since, response);
}

Response Api::of_error(const Error& error, const std::string& request_id) const {
  const auto seen = shown(error.fault, error.problems, settings_.hidden);
  const int status = status_of(error.fault, error.problems);
  if (status >= 500) log_fault(error.what(), request_id);
  return problem(status, "The request could not be carried out.", seen);
}

/// The answer to a request without a key that this route needs. Notes whose key it has.
std::optional<Response> Api::refusal(const Route& route, Request& request) const {
  if (settings_.keys.empty()) return std::nullopt;
  const auto key = settings_.keys.find(request.header("authorization"));
  request.owner = key ? key->name : "";
  request.all_owners = key && key->may(Scope::admin);
  if (!route.needs || (key && key->may(*route.needs))) return std::nullopt;
  auto response = !key ? problem(401, "This needs a key: Authorization: Bearer KEY.")
                       : problem(403, "The key does not have the scope for this.");
  response.headers.emplace_back(
      "WWW-Authenticate",
      !key ? std::string("Bearer realm=\"hoodoo\"")
           : fmt::format("Bearer realm=\"hoodoo\", error=\"insufficient_scope\", "
                         "scope=\"{}\"",
                         name_of(*route.needs)));
  return response;
}

/// What every answer has.
void Api::finish(const Request& request, Response& response) {
  tag(request, response);
  const auto wanted = request.header("if-match"), etag = response.header("ETag");
  const bool is_read = response.status == 200 || response.status == 206 || response.status == 304;
  if (is_read && !wanted.empty() && !etag.empty() && !lists(wanted, etag, Comparison::strong)) {
    response = problem(412, "What is there is not what If-Match says.");
  }
  encoder_.apply(request, response);
  response.headers.emplace_back("X-Content-Type-Options", "nosniff");
  if (tus::is_path(request.path)) response.headers.emplace_back("Tus-Resumable", tus::version);
  if (is_open_to_pages(request.path)) {
    response.headers.emplace_back("Access-Control-Allow-Origin", "*");
    response.headers.emplace_back("Access-Control-Expose-Headers",
                                  "ETag, Content-Range, Content-Length, Accept-Ranges");
  }
}

Response Api::route(Request& request, std::string_view& pattern) {
  const auto& hosts = settings_.hosts;
  if (!hosts.empty() && std::ranges::find(hosts, request.header("host")) == hosts.end()) {
    return problem(421, "This server does not answer for that host; see --public-url.");
  }
  if (request.path.size() > most_path) return problem(414, "The path is too long.");
  tus::override_method(request);
  std::string_view path = request.path;
  if (!path.starts_with('/')) return problem(404, "There is nothing at this path.");
  path.remove_prefix(1);
  std::string_view method = request.method;
  if (method == "HEAD") method = "GET";
  std::string allowed;
  for (const auto& candidate : routes()) {
    const auto parameters = match(candidate.pattern, path);
    if (!parameters) continue;
    pattern = candidate.pattern;
    if (candidate.method == method || candidate.method == request.method) {
      if (auto refused = refusal(candidate, request)) return std::move(*refused);
      return (this->*candidate.handler)(request, *parameters);
    }
    allowed += std::string(allowed.empty() ? "" : ", ") + std::string(candidate.method);
    if (candidate.method == "GET") allowed += ", HEAD";
  }
  if (allowed.empty()) return problem(404, "There is nothing at this path.");
  allowed += ", OPTIONS";
  if (method == "OPTIONS") {
    Response response;
    response.status = 204;
    response.headers = {{"Allow", allowed}};
    if (tus::is_path(request.path)) {
      response.headers.emplace_back("Tus-Version", tus::version);
      response.headers.emplace_back("Tus-Extension", tus::extensions);
      response.headers.emplace_back("Tus-Max-Size", std::to_string(assets_.most()));
      response.headers.emplace_back("Tus-Checksum-Algorithm", "sha256");
    }
    if (is_open_to_pages(request.path)) {
      response.headers.emplace_back("Access-Control-Allow-Methods", "GET, HEAD");
      response.headers.emplace_back("Access-Control-Allow-Headers",
                                    "Range, If-None-Match, If-Range, Prefer, Last-Event-ID");
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
Response Api::conforms(const Request&, const Parameters&) {
  return document(conformance(!settings_.callbacks.empty()));
}
Response Api::health(const Request&, const Parameters&) { return document({{"status", "ok"}}); }

/// Where a balancer asks whether to send requests here.
Response Api::ready(const Request&, const Parameters&) {
  if (is_draining()) return document({{"status", "draining"}}, 503);
  queue_.count(job::Status::accepted);  // the jobs can be read
  return document({{"status", "ready"}});
}

Response Api::metrics(const Request&, const Parameters&) {
  Response response;
  response.type = "text/plain; version=0.0.4; charset=utf-8";
  response.headers = {{"Cache-Control", "no-store"}};
  response.body =
      metrics_.text(queue_, settings_.connections ? settings_.connections() : ConnectionCounts());
  return response;
}

Response Api::processes(const Request&, const Parameters&) {
  return document(process_list(settings_.base));
}

Response Api::process(const Request&, const Parameters& parameters) {
  if (!control_of(parameters[0])) {
    return problem(404, "There is no such process.", {},
                   std::string(problem_types) + "no-such-process");
  }
  return document(process_description(parameters[0], settings_.base, settings_.scene_schema()));
}

Response Api::api_document(const Request&, const Parameters&) {
  auto response = document(openapi(settings_.base));
  response.type = "application/vnd.oai.openapi+json;version=3.0";
  return response;
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
  auto response =
      serve_file({settings_.viewer, {".html", ".css", ".js", ".json", ".wasm", ".svg", ".tif"}},
                 name, request);
  // What a page may load stands in the page itself; these a page cannot set.
  response.headers.emplace_back("Content-Security-Policy",
                                "frame-ancestors 'none'; base-uri 'none'; form-action 'none'");
  response.headers.emplace_back("Referrer-Policy", "no-referrer");
  return response;
}

}  // namespace hoodoo::http
