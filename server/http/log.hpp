#pragma once
#include <cstdint>
#include <string>

/// What the service says of itself while it runs: a line for each event, on stderr.
namespace hoodoo::http {

enum class LogFormat : std::uint8_t { text, json };

/// One answered request. In JSON: time, level, event "request", request, method, path, status,
/// milliseconds, client, the address that the connection comes from, and where there are such
/// forwarded, whom a gateway on this machine says that it asks for, job and owner.
struct RequestLine {
  std::string id, method, path, client, forwarded, job, owner;
  int status = 0;
  double milliseconds = 0;
};

/// One try of a callback. In JSON: time, level, event "callback", delivery, job, status, tries,
/// milliseconds, why where there was no answer, and given_up.
struct CallbackLine {
  std::string delivery, job, why;
  int status = 0, tries = 0;
  bool given_up = false;
  double milliseconds = 0;
};

/// Requests are told in JSON alone: as text only faults are.
void set_log_format(LogFormat format);
void log_request(const RequestLine& line);
/// As text only one that is given up.
void log_callback(const CallbackLine& line);
/// What went wrong inside, which no client is told.
void log_fault(const std::string& what, const std::string& request_id);

}  // namespace hoodoo::http
