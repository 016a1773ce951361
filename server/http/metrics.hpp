#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "server/http/entrance.hpp"
#include "server/job/queue.hpp"

/// What the service tells those who watch it, in Prometheus' text format.
namespace hoodoo::http {

class Metrics {
 public:
  Metrics();
  ~Metrics();

  /// One request: the route's pattern, not the path, so that series stay few. `seconds` to the
  /// answer, without sending it.
  void count(std::string_view route, std::string_view method, int status, double seconds);
  /// All of it, with the jobs, the connections and the process as they are now.
  std::string text(const job::Queue& queue, const ConnectionCounts& connections);

 private:
  struct Registry;
  std::unique_ptr<Registry> registry_;
};

}  // namespace hoodoo::http
