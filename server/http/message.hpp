#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// What a route sees and gives, whatever library talks to the socket.
namespace hoodoo::http {

struct Request {
  std::string method;                                       // upper case
  std::string path;                                         // decoded, without the query
  std::string query;                                        // as sent, without the question mark
  std::map<std::string, std::string, std::less<>> headers;  // lower-case names
  std::string body;
  std::string owner;       // whose key it came with; empty: nobody's
  bool all_owners = true;  // may see and end everybody's jobs
  std::string peer{};      // address that the connection comes from
  std::string id{};        // in logs, and the answer's X-Request-Id

  /// Empty when absent.
  std::string_view header(std::string_view lower_case_name) const {
    const auto found = headers.find(lower_case_name);
    return found == headers.end() ? std::string_view() : std::string_view(found->second);
  }
};

/// A part of an open file, read when it is sent.
struct FilePart {
  std::shared_ptr<const int> file;       // descriptor
  std::uint64_t offset = 0, length = 0;  // [bytes]
};

/// How the body of a request came.
enum class Received : std::uint8_t {
  whole,
  refused,  // by whoever took it
  slow,     // its sender dawdled
  stopped,  // the server is about to stop
  broken    // the connection ended
};
/// Gives a body piece by piece, as it comes, until there is no more or `use` wants none.
using UsePiece = std::function<bool(std::string_view piece)>;
using ReadBody = std::function<Received(const UsePiece& use)>;

struct Response {
  int status = 200;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string type;  // of the content
  std::string body;
  std::optional<FilePart> part;             // instead of a body
  std::shared_ptr<const std::string> text;  // instead of one, too: shared with other answers
  std::shared_ptr<const void> held;         // until all has been sent

  /// Instead of all that, for a request whose body has not been read: reads it, and gives the
  /// response. Called once, or never.
  std::function<Response(const ReadBody&)> take;
  /// Instead of all that: the response once there is one. Asked again and again, from any thread.
  /// `at_once`: there is no time any more, and always a response.
  std::function<std::optional<Response>(bool at_once)> later;
  /// Instead of a body: what follows, "" for nothing yet, nothing at the end. Asked again and
  /// again, too.
  std::function<std::optional<std::string>()> more;

  /// Empty when absent.
  std::string_view header(std::string_view name) const {
    for (const auto& [key, value] : headers) {
      if (key == name) return value;
    }
    return {};
  }
};

}  // namespace hoodoo::http
