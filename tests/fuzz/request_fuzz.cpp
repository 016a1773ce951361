// Any bytes as what a client sends over one connection, to a server with and without keys: each
// answer is whole, of a documented status, and says what it says as it should; none is of a fault.
//
// With libFuzzer: -dict=tests/fuzz/request.dict
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "server/http/api.hpp"
#include "server/http/listener.hpp"

using namespace hoodoo;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::string_view key = "hoodoo_0000000000000000";

void require(bool holds, std::string_view what) {
  if (holds) return;
  std::fprintf(stderr, "%.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

job::Settings queue_of(const fs::path& folder) {
  job::Settings settings;
  settings.data = folder / "data";
  settings.keep = std::chrono::seconds(1);
  return settings;
}

/// Looks at a scene's first problem, and takes any other job for done.
job::Engine engine() {
  return {[](const fs::path& file) {
            std::vector<Problem> problems;
            if (parse_json(read_file(file, 1u << 24), "scene").contains("bad")) {
              problems = {{"/bad", "is an unknown key"}};
            }
            return problems;
          },
          [](const job::Work&) { return job::Outcome(); }};
}

http::ApiSettings settings_of(const fs::path& folder, bool has_keys) {
  http::ApiSettings settings;
  settings.base = "http://a";
  settings.viewer = folder / "viewer";
  settings.roots = {folder};
  settings.hidden = {folder.string() + "/"};
  settings.scene_schema = [] { return json::object(); };
  if (has_keys) settings.keys = http::KeyRing(folder / "keys.json");
  return settings;
}

/// A service on a free port, over a folder of its own.
class Server {
 public:
  Server(const fs::path& folder, bool has_keys)
      : queue_(queue_of(folder), engine()),
        assets_(folder / "data", 1 << 20),
        uploads_(assets_, std::chrono::seconds(1)),
        api_(queue_, assets_, uploads_, settings_of(folder, has_keys)),
        thread_([this](const std::stop_token& stop) {
          listener_.run({[this](http::Request request) { return api_.answer(std::move(request)); },
                         &http::Api::takes_body,
                         [this](http::Request request, http::Response& response,
                                http::Api::Clock::time_point since) {
                           api_.note(std::move(request), response, since);
                         }},
                        stop);
        }) {}
  int port() const { return listener_.port(); }

 private:
  job::Queue queue_;
  asset::Assets assets_;
  asset::Uploads uploads_;
  http::Api api_;
  http::Listener listener_{"127.0.0.1", 0};
  std::jthread thread_;
};

/// The folder of everything, gone at the end.
class Folder {
 public:
  Folder() : path(fs::temp_directory_path() / ("hoodoo-fuzz-" + std::to_string(::getpid()))) {
    fs::create_directories(path / "viewer");
    for (const auto* name : {"open", "keyed"}) fs::create_directories(path / name / "data");
    write_file(path / "open/viewer/index.html", "<!doctype html>");
    write_file(path / "open/scene.json", "{\"hoodoo\": 1}");
    const json one{{"name", "a"}, {"sha256", sha256(key).hex()}, {"scopes", {"read", "submit"}}};
    write_file(path / "keyed/keys.json", json{{"keys", json::array({one})}}.dump());
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const fs::path path;
};

/// All that is answered to `bytes`.
std::string converse(int port, std::string_view bytes) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const linger no_wait{1, 0};  // else so many connections use up the ports
  ::setsockopt(socket, SOL_SOCKET, SO_LINGER, &no_wait, sizeof no_wait);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const auto* to = reinterpret_cast<const sockaddr*>(&address);
  // Others on the machine may have taken the ports for a while.
  int patience = 60;  // [s]
  while (::connect(socket, to, sizeof address) != 0) {
    const int why = errno;
    const bool may_come = why == EADDRNOTAVAIL || why == EADDRINUSE || why == EINTR;
    require(may_come && --patience > 0, "no connection: " + std::generic_category().message(why));
    std::this_thread::sleep_for(std::chrono::seconds(1));
  }
  while (!bytes.empty()) {
    const auto sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) break;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  ::shutdown(socket, SHUT_WR);
  std::string answer;
  std::array<char, 1 << 14> piece;
  for (ssize_t got = 0; (got = ::recv(socket, piece.data(), piece.size(), 0)) > 0;) {
    answer.append(piece.data(), static_cast<std::size_t>(got));
  }
  ::close(socket);
  return answer;
}

/// The value of a header of a head; empty when there is none.
std::string_view header(std::string_view head, std::string_view name) {
  const auto at = head.find("\r\n" + std::string(name) + ": ");
  if (at == head.npos) return {};
  const auto from = at + name.size() + 4;
  return head.substr(from, head.find("\r\n", from) - from);
}

/// Takes the first answer off, and looks at it.
void take(std::string_view& answers) {
  static const std::set<std::string_view> documented{
      "100", "200", "201", "204", "206", "303", "304", "308", "400", "401", "403",
      "404", "405", "408", "409", "411", "412", "413", "414", "415", "416", "421",
      "422", "423", "429", "431", "460", "501", "503", "505", "507"};
  constexpr std::string_view line = "HTTP/1.1 ";
  require(answers.starts_with(line), "no answer begins here");
  const auto end = answers.find("\r\n\r\n");
  require(end != answers.npos, "a head without an end");
  const auto head = answers.substr(0, end + 2), status = head.substr(line.size(), 3);
  require(documented.contains(status), "a status that no document has");
  require(head.find('\0') == head.npos, "a zero in a head");
  answers.remove_prefix(end + 4);
  if (status == "100") return;
  require(!header(head, "Date").empty(), "an answer without a date");
  const bool empty = status == "204" || status == "304";
  require(empty == header(head, "Content-Length").empty(), "a length, or none");
  std::size_t length = 0;
  const auto text = header(head, "Content-Length");
  std::from_chars(text.data(), text.data() + text.size(), length);
  // Of what a HEAD asked for nothing follows but the next answer, or the end.
  if (length == 0 || answers.empty() || answers.starts_with(line)) return;
  require(answers.size() >= length, "a body that is cut short");
  const auto body = answers.substr(0, length);
  answers.remove_prefix(length);
  const auto type = header(head, "Content-Type");
  const bool whole = status != "206" && type.find("json") != type.npos;
  require(status < "400" || type == "application/problem+json", "a problem of another type");
  const auto said = whole ? json::parse(body, nullptr, false) : json();
  require(!said.is_discarded(), "JSON that is none");
  if (status >= "400") require(std::to_string(said["status"].get<int>()) == status, "two statuses");
}

}  // namespace

// libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  static Server open(folder.path / "open", false), keyed(folder.path / "keyed", true);
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (bytes.find("pause") != bytes.npos) return 0;  // it would take its time
  const bool has_key = bytes.find("uthorization") != bytes.npos;
  const auto answers = converse((has_key ? keyed : open).port(), bytes);
  for (std::string_view rest = answers; !rest.empty();) take(rest);
  return 0;
}
