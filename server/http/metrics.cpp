#include "server/http/metrics.hpp"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <map>
#include <mutex>
#include <tuple>

#include "server/job/state.hpp"

namespace hoodoo::http {
namespace {

using prometheus::BuildCounter, prometheus::BuildGauge, prometheus::BuildHistogram;

/// [bytes]
double resident_memory() {
  std::ifstream file("/proc/self/statm");
  double whole = 0, resident = 0;
  file >> whole >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

constexpr std::array statuses{job::Status::accepted, job::Status::running, job::Status::successful,
                              job::Status::failed, job::Status::dismissed};

}  // namespace

/// What one kind of request counts into.
struct Series {
  prometheus::Counter& requests;
  prometheus::Histogram& seconds;
};

struct Metrics::Registry {
  prometheus::Registry all;
  prometheus::Family<prometheus::Counter>& requests =
      BuildCounter().Name("hoodoo_http_requests_total").Help("Requests answered.").Register(all);
  prometheus::Family<prometheus::Histogram>& seconds =
      BuildHistogram()
          .Name("hoodoo_http_request_duration_seconds")
          .Help("Time until there was an answer, without sending it.")
          .Register(all);
  prometheus::Family<prometheus::Gauge>& jobs =
      BuildGauge().Name("hoodoo_jobs").Help("Jobs that are kept, by status.").Register(all);
  prometheus::Gauge& callbacks_pending = BuildGauge()
                                             .Name("hoodoo_callbacks_pending")
                                             .Help("Callbacks that are owed.")
                                             .Register(all)
                                             .Add({});
  prometheus::Family<prometheus::Counter>& callbacks =
      BuildCounter()
          .Name("hoodoo_callbacks_total")
          .Help("Callbacks: delivered, tries that failed, given up.")
          .Register(all);
  prometheus::Gauge& connections_open = BuildGauge()
                                            .Name("hoodoo_http_connections")
                                            .Help("Connections that are open.")
                                            .Register(all)
                                            .Add({});
  prometheus::Family<prometheus::Counter>& connections =
      BuildCounter()
          .Name("hoodoo_http_connections_total")
          .Help(
              "Connections: accepted; of them dropped while they waited, or refused, for want of "
              "room; slow: cut off as readers.")
          .Register(all);
  prometheus::Gauge& memory = BuildGauge()
                                  .Name("process_resident_memory_bytes")
                                  .Help("Resident memory of the server, without its jobs.")
                                  .Register(all)
                                  .Add({});
  // Finding a series by its labels takes longer than most answers.
  std::mutex mutex;
  std::mutex telling;  // one scrape at a time brings totals up to date
  std::map<std::tuple<std::string, std::string, int>, Series> series;

  const Series& of(std::string_view route, std::string_view method, int status) {
    const std::lock_guard guard(mutex);
    const std::string name(route), verb(method);
    const auto known = series.find({name, verb, status});
    if (known != series.end()) return known->second;
    const prometheus::Histogram::BucketBoundaries buckets{0.001, 0.005, 0.025, 0.1,
                                                          0.5,   2.5,   10,    60};
    const Series made{
        requests.Add({{"route", name}, {"method", verb}, {"code", std::to_string(status)}}),
        seconds.Add({{"route", name}}, buckets)};
    return series.emplace(std::tuple(name, verb, status), made).first->second;
  }
};

Metrics::Metrics() : registry_(std::make_unique<Registry>()) {}
Metrics::~Metrics() = default;

void Metrics::count(std::string_view route, std::string_view method, int status, double seconds) {
  const auto& series = registry_->of(route, method, status);
  series.requests.Increment();
  series.seconds.Observe(seconds);
}

std::string Metrics::text(const job::Queue& queue, const ConnectionCounts& connections) {
  const std::lock_guard guard(registry_->telling);
  for (const auto status : statuses) {
    registry_->jobs.Add({{"status", std::string(job::name_of(status))}})
        .Set(static_cast<double>(queue.count(status)));
  }
  const auto count_to = [](auto& family, const char* result, std::uint64_t total) {
    auto& counter = family.Add({{"result", result}});
    counter.Increment(static_cast<double>(total) - counter.Value());
  };
  const auto told = queue.told();
  registry_->callbacks_pending.Set(static_cast<double>(told.pending));
  count_to(registry_->callbacks, "delivered", told.delivered);
  count_to(registry_->callbacks, "failed", told.failed_tries);
  count_to(registry_->callbacks, "given_up", told.given_up);
  registry_->connections_open.Set(static_cast<double>(connections.open));
  count_to(registry_->connections, "accepted", connections.accepted);
  count_to(registry_->connections, "dropped", connections.dropped);
  count_to(registry_->connections, "slow", connections.slow);
  count_to(registry_->connections, "refused", connections.refused);
  registry_->memory.Set(resident_memory());
  return prometheus::TextSerializer().Serialize(registry_->all.Collect());
}

}  // namespace hoodoo::http
