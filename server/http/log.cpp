#include "server/http/log.hpp"

#include <fmt/chrono.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>

namespace hoodoo::http {
namespace {

std::atomic<LogFormat> wanted = LogFormat::text;

spdlog::logger& logger() {
  static const auto made = [] {
    auto log = std::make_shared<spdlog::logger>("hoodoo",
                                                std::make_shared<spdlog::sinks::stderr_sink_mt>());
    log->set_pattern("%v");
    return log;
  }();
  return *made;
}

std::string now() {
  const auto time = std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  const auto part = time.time_since_epoch().count() % 1000;
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03d}Z",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(time)), part);
}

void write(const nlohmann::ordered_json& line) {
  logger().info(line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace

void set_log_format(LogFormat format) { wanted = format; }

void log_request(const RequestLine& line) {
  if (wanted != LogFormat::json) return;
  nlohmann::ordered_json all{{"time", now()},         {"level", "info"},
                             {"event", "request"},    {"request", line.id},
                             {"method", line.method}, {"path", line.path},
                             {"status", line.status}, {"milliseconds", line.milliseconds}};
  if (!line.client.empty()) all["client"] = line.client;
  if (!line.forwarded.empty()) all["forwarded"] = line.forwarded;
  if (!line.job.empty()) all["job"] = line.job;
  if (!line.owner.empty()) all["owner"] = line.owner;
  write(all);
}

void log_callback(const CallbackLine& line) {
  if (wanted == LogFormat::json) {
    nlohmann::ordered_json all{{"time", now()},
                               {"level", line.given_up ? "error" : "info"},
                               {"event", "callback"},
                               {"delivery", line.delivery},
                               {"job", line.job},
                               {"status", line.status},
                               {"tries", line.tries},
                               {"milliseconds", line.milliseconds},
                               {"given_up", line.given_up}};
    if (!line.why.empty()) all["why"] = line.why;
    write(all);
  } else if (line.given_up) {
    logger().error("hoodoo: callback {} is given up after {} tries: {}", line.delivery, line.tries,
                   line.why.empty() ? fmt::format("answered {}", line.status) : line.why);
  }
}

void log_fault(const std::string& what, const std::string& request_id) {
  if (wanted == LogFormat::json) {
    write({{"time", now()},
           {"level", "error"},
           {"event", "fault"},
           {"request", request_id},
           {"what", what}});
  } else {
    logger().error("hoodoo: {}", what);
  }
}

}  // namespace hoodoo::http
