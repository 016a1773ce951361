#include <fmt/core.h>

#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "server/http/api.hpp"
#include "server/http/problem.hpp"
#include "server/http/processes.hpp"
#include "server/http/query.hpp"
#include "server/http/tokens.hpp"
#include "server/http/turn.hpp"

/// POST /processes/ID/execution.
namespace hoodoo::http {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

/// A document of the one output, or the output itself.
Response outputs(const char* name, json value, bool raw) {
  if (!raw) return document({{name, std::move(value)}});
  return document(value);
}

/// What a job echoes is kept with it.
std::optional<Response> echo_refusal(const job::Request& wanted, bool async) {
  if (!async || wanted.process != echo_process) return std::nullopt;
  const auto size =
      wanted.inputs.at("echo").dump(-1, ' ', false, json::error_handler_t::replace).size();
  if (size <= most_kept) return std::nullopt;
  return problem(413, "The request cannot be taken.",
                 {{"/inputs/echo", fmt::format("must be of at most {} bytes as JSON in a job, got "
                                               "{}; without respond-async it may be larger",
                                               most_kept, size)}});
}

constexpr std::chrono::seconds patience_with_checks{10};

struct Busy {};

Response busy() {
  auto refusal = problem(503, "As many scenes are looked at as may be at once.");
  refusal.headers.emplace_back("Retry-After", "5");
  return refusal;
}

bool is_baked(const std::optional<job::Job>& job) {
  return job && job->status == job::Status::successful && job->process == job::bake_process;
}

}  // namespace

References Api::references(const Request& request) const {
  return {settings_.base, settings_.roots,
          [this](std::string_view name) {
            std::optional<std::filesystem::path> folder;
            const auto job = queue_.find(name);
            if (is_baked(job)) folder = queue_.results(name);
            return job ? folder : settings_.tilesets.folder(name);
          },
          [this, &request](std::string_view id, bool read) -> std::optional<std::filesystem::path> {
            const auto job = queue_.find(id);
            if (!is_baked(job)) return std::nullopt;
            const bool may_read = request.all_owners || job->owner == request.owner;
            if (read && !may_read) return std::nullopt;
            return queue_.results(id).parent_path() / "scene.json";
          },
          [] {}};
}

Response Api::execute(const Request& request, const Parameters& parameters) {
  const auto control = control_of(parameters[0]);
  if (!control) return process(request, parameters);
  if (is_draining()) {
    auto refusal = problem(503, "The server is about to stop.");
    refusal.headers.emplace_back("Retry-After", "5");
    return refusal;
  }
  // A page of another origin can send this type only after a preflight, which is refused.
  if (!is_media_type(request.header("content-type"), "application/json")) {
    return problem(415, "Send the execution as application/json.");
  }
  // Parsed it takes many times its size.
  std::unique_lock turn(large_, std::defer_lock);
  if (request.body.size() > most_paused && !turn.try_lock_for(patience_with_checks)) return busy();
  auto references = this->references(request);
  references.before_reading = [&turn] {
    if (!turn.owns_lock() && !turn.try_lock_for(patience_with_checks)) throw Busy();
  };
  Execution execution;
  try {
    execution = read_execution(parameters[0], request, references);
  } catch (const Busy&) {
    return busy();
  } catch (const Error& error) {
    if (error.fault == Fault::internal || error.fault == Fault::io) throw;
    return problem(error.fault == Fault::limit ? 413 : 400,
                   "The body must be {\"inputs\": {...}} with the inputs of the process.",
                   shown(error.fault, error.problems, settings_.hidden));
  }
  const bool async = control->async && (!control->sync || preferences_of(request).respond_async);
  auto& wanted = execution.request;
  if (auto refused = callback_refusal(wanted.subscriber, async)) return std::move(*refused);
  if (auto refused = echo_refusal(wanted, async)) return std::move(*refused);
  wanted.quota = quota_of(request);
  if (async) return submit(wanted);
  if (wanted.process == validate_process) return validate(wanted, execution.raw);
  const std::chrono::duration<double> pause(wanted.inputs["pause"].get<double>());
  const auto at = Clock::now() + std::chrono::duration_cast<Clock::duration>(pause);
  auto ready = outputs("echo", std::move(wanted.inputs["echo"]), execution.raw);
  if (pause.count() <= 0) return ready;
  Response response;
  response.later = [at, ready = std::move(ready)](bool at_once) -> std::optional<Response> {
    if (!at_once && Clock::now() < at) return std::nullopt;
    return ready;
  };
  return response;
}

job::Quota Api::quota_of(const Request& request) const {
  if (settings_.keys.empty()) return {};
  if (const auto key = settings_.keys.find(request.header("authorization"))) return key->quota;
  job::Quota none;  // of a key that has just been taken away
  none.jobs = none.bytes = 0;
  return none;
}

/// None of what a request names is asked before its job runs.
std::optional<Response> Api::callback_refusal(const job::Subscriber& subscriber, bool async) const {
  if (subscriber.empty()) return std::nullopt;
  if (settings_.callbacks.empty()) {
    return problem(400, "The request cannot be taken.",
                   {{"/subscriber", "callbacks are not offered"}});
  }
  if (!async) {
    return problem(400, "The request cannot be taken.",
                   {{"/subscriber", "is for jobs alone; send Prefer: respond-async for one"}});
  }
  std::vector<Problem> problems;
  const auto look = [&](const std::string& uri, const char* pointer) {
    if (uri.empty() || settings_.callbacks.lets(target_of(uri, pointer))) return;
    problems.push_back({pointer, "leads to a host that this server may not call"});
  };
  look(subscriber.success, "/subscriber/successUri");
  look(subscriber.in_progress, "/subscriber/inProgressUri");
  look(subscriber.failed, "/subscriber/failedUri");
  if (problems.empty()) return std::nullopt;
  return problem(422, "The subscriber cannot be called.", problems);
}

/// A scene with problems is a good answer of this process.
Response Api::validate(const job::Request& wanted, bool raw) {
  const Turn turn(checks_, patience_with_checks);
  if (!turn) return busy();
  std::vector<Problem> found;
  try {
    found = queue_.check(wanted.inputs.at("scene"));
  } catch (const Error& error) {
    if (error.fault == Fault::internal || error.fault == Fault::io) throw;
    found = error.problems;
  }
  json problems = json::array();
  for (const auto& one : shown(Fault::bad_input, found, settings_.hidden)) {
    problems.push_back({{"pointer", one.where}, {"detail", one.what}});
  }
  const json all{{"valid", problems.empty()}, {"problems", problems}};
  const auto& names = wanted.outputs;
  if (raw) return document(all.at(names.size() == 1 ? names.front() : "problems"));
  json asked = json::object();
  for (const auto& name : names) asked[name] = all.at(name);
  return document(names.empty() ? all : asked);
}

Response Api::submit(const job::Request& wanted) {
  std::optional<Turn> turn;
  const bool is_bake = wanted.process == job::bake_process;
  if (is_bake && !turn.emplace(checks_, patience_with_checks)) return busy();
  try {
    return answer_to(queue_.submit(wanted));
  } catch (const Error& error) {
    if (error.fault != Fault::bad_input) throw;
    return problem(422, "The scene has problems.",
                   shown(error.fault, error.problems, settings_.hidden));
  }
}

Response Api::answer_to(const job::Submitted& submitted) const {
  using Kind = job::Submitted::Kind;
  if (submitted.kind == Kind::queue_full || submitted.kind == Kind::owner_full) {
    auto refusal = submitted.kind == Kind::queue_full
                       ? problem(503, "Too many jobs are waiting.")
                       : problem(429, fmt::format("You have {} jobs under way, and may have {}.",
                                                  submitted.used, submitted.most));
    refusal.headers.emplace_back("Retry-After", "60");
    return refusal;
  }
  if (submitted.kind == Kind::owner_space) return over_quota(submitted.used, 0, submitted.most);
  if (submitted.kind == Kind::key_reused) {
    return problem(422, "This Idempotency-Key came with another request before.");
  }
  auto response = document(info(submitted.job), submitted.kind == Kind::taken ? 201 : 200);
  response.headers.emplace_back("Location", settings_.base + "/jobs/" + submitted.job.id);
  response.headers.emplace_back("Preference-Applied", "respond-async");
  return response;
}

}  // namespace hoodoo::http
