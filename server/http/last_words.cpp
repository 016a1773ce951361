#include "server/http/last_words.hpp"

#include <fmt/chrono.h>
#include <fmt/core.h>
#include <httplib.h>

#include <chrono>

#include "server/http/problem.hpp"

namespace hoodoo::http {

std::string date() {
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%a, %d %b %Y %H:%M:%S} GMT", fmt::gmtime(now));
}

std::string last_words(const Response& response) {
  std::string more;
  for (const auto& [name, value] : response.headers) more += fmt::format("{}: {}\r\n", name, value);
  return fmt::format(
      "HTTP/1.1 {} {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nDate: {}\r\n{}"
      "Connection: close\r\n\r\n{}",
      response.status, httplib::status_message(response.status), response.type,
      response.body.size(), date(), more, response.body);
}

Response too_many() {
  auto refused = problem(503, "There are too many connections.");
  refused.headers.emplace_back("X-Content-Type-Options", "nosniff");
  refused.headers.emplace_back("Retry-After", "1");
  return refused;
}

}  // namespace hoodoo::http
