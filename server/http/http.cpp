#include "server/http/http.hpp"

#include <fmt/core.h>
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>

#include "engine/base/error.hpp"
#include "server/asset/uploads.hpp"
#include "server/http/api.hpp"
#include "server/http/asset_keeper.hpp"
#include "server/http/courier.hpp"
#include "server/http/documents.hpp"
#include "server/http/listener.hpp"
#include "server/http/log.hpp"
#include "server/job/commands.hpp"

namespace hoodoo::http {
namespace {

namespace fs = std::filesystem;

bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}
bool is_wildcard(std::string_view host) { return host == "0.0.0.0" || host == "::"; }

/// "host:port" of an address "http://host:port"; empty when it is none.
std::string authority_of(std::string_view url) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!url.starts_with(scheme)) continue;
    url.remove_prefix(scheme.size());
    return std::string(url.substr(0, url.find('/')));
  }
  return {};
}

std::string base_of(const Settings& settings, int port) {
  if (settings.public_url.empty()) {
    const bool v6 = settings.host.find(':') != settings.host.npos;
    return fmt::format(fmt::runtime(v6 ? "http://[{}]:{}" : "http://{}:{}"), settings.host, port);
  }
  auto url = settings.public_url;
  while (url.ends_with('/')) url.pop_back();
  return url;
}

std::vector<std::string> hosts_of(const Settings& settings, int port) {
  if (!is_loopback(settings.host)) return {};
  std::vector<std::string> hosts;
  for (const auto* name : {"localhost", "127.0.0.1", "[::1]"}) {
    hosts.push_back(fmt::format("{}:{}", name, port));
    if (port == 80) hosts.emplace_back(name);
  }
  hosts.push_back(authority_of(base_of(settings, port)));
  return hosts;
}

void check(const Settings& settings) {
  if (settings.public_url.empty() && is_wildcard(settings.host)) {
    throw Error(Fault::bad_input, "--public-url",
                "is needed when listening on all addresses: answers hold absolute links");
  }
  if (settings.keys.empty() && !is_loopback(settings.host)) {
    throw Error(
        Fault::bad_input, "--keys",
        "is needed where others can reach the server; without it only a loopback address is "
        "served, got " +
            settings.host);
  }
  if (!settings.public_url.empty() && authority_of(settings.public_url).empty()) {
    throw Error(Fault::bad_input, "--public-url",
                "must start with http:// or https:// and a host, got " + settings.public_url);
  }
}

/// None where nobody is called.
std::optional<Sender> sender_of(const Settings& settings) {
  if (settings.callbacks.empty()) return std::nullopt;
  if (settings.callback_secret.empty()) {
    throw Error(Fault::bad_input, "--callback-secret", "is needed with --callback-allow");
  }
  return Sender(AllowList(settings.callbacks, "--callback-allow"),
                read_secret(settings.callback_secret));
}

/// Beside the command in a build folder, under share/ once installed.
fs::path find_viewer() {
  std::error_code error;
  const auto command = fs::read_symlink("/proc/self/exe", error);
  for (const auto* place : {"viewer", "../share/hoodoo/viewer"}) {
    const auto folder = command.parent_path() / place;
    if (fs::exists(folder / "index.html", error)) return fs::canonical(folder, error);
  }
  return {};
}

std::vector<std::string> hidden_of(const Settings& settings) {
  std::vector<std::string> hidden;
  auto folders = settings.roots;
  folders.insert(folders.end(), settings.tilesets.begin(), settings.tilesets.end());
  folders.push_back(settings.data);
  folders.push_back(settings.cache);
  for (const auto& folder : folders) {
    std::error_code error;
    for (const auto& name : {fs::canonical(folder, error), folder}) {
      if (!name.empty() && name != "." && name != "/") hidden.push_back(name.string() + "/");
    }
  }
  return hidden;
}

/// Folders that jobs may read, links followed; the assets are always one.
job::Commands commands_of(const Settings& settings) {
  job::Commands commands;
  std::error_code error;
  for (const auto& root : settings.roots) {
    const auto real = fs::canonical(root, error);
    if (error || !fs::is_directory(real, error)) {
      throw Error(Fault::not_found, root.string(), "is no folder to read elevations from");
    }
    commands.roots.push_back(real);
  }
  const auto assets = settings.data / "assets";
  fs::create_directories(assets, error);
  if (error) throw Error(Fault::io, assets.string(), "cannot be made: " + error.message());
  commands.roots.push_back(fs::canonical(assets));
  commands.program = settings.program;
  commands.cache = settings.cache;
  commands.threads = settings.threads;
  commands.memory = settings.memory;
  commands.limits = settings.limits;
  return commands;
}

/// Requests the stop of `drained` so long after that of the settings; gives up when `over`.
void wait_to_drain(const Settings& settings, const std::stop_token& over,
                   std::stop_source& drained) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any changed;
  const std::stop_callback wake(settings.stop, [&changed] { changed.notify_all(); });
  const auto asked = [&settings] { return settings.stop.stop_requested(); };
  // A call to stop between the look and the wait is seen by the next look.
  while (!over.stop_requested() && !asked()) {
    changed.wait_for(lock, over, std::chrono::milliseconds(100), asked);
  }
  changed.wait_for(lock, over, settings.drain, [] { return false; });
  drained.request_stop();
}

/// Memory that one large request has taken goes back to the system; threads share what is kept.
void keep_small() {
  ::mallopt(M_ARENA_MAX, 2);
  ::mallopt(M_TRIM_THRESHOLD, 1 << 20);
}

/// Gives the most descriptors there may be, which many systems leave to who needs them.
std::size_t raise_descriptors() {
  rlimit both{};
  ::getrlimit(RLIMIT_NOFILE, &both);
  both.rlim_cur = both.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &both);
  ::getrlimit(RLIMIT_NOFILE, &both);
  return both.rlim_cur;
}

}  // namespace

void serve(const Settings& given) {
  keep_small();
  // Of each connection a socket, a file, and the folder in which that is looked for.
  const auto most_connections = std::min(given.connections, raise_descriptors() / 3);
  auto settings = given;
  std::erase_if(settings.host, [](char c) { return c == '[' || c == ']'; });
  check(settings);
  const auto sender = sender_of(settings);
  const Tilesets tilesets(settings.tilesets);
  Listener listener(settings.host, settings.port, most_connections);
  const auto commands = commands_of(settings);
  job::Settings queue_settings;
  queue_settings.data = settings.data;
  queue_settings.at_once = settings.at_once;
  queue_settings.most_waiting = settings.most_waiting;
  queue_settings.keep = settings.keep;
  queue_settings.free_space = settings.free_space;
  if (sender) {
    queue_settings.announce = [base = base_of(settings, listener.port()),
                               hidden = hidden_of(settings)](const job::Job& job,
                                                             const fs::path& results) {
      return announcement(job, results, base, hidden);
    };
  }
  job::Queue queue(std::move(queue_settings),
                   {[commands](const fs::path& scene) { return commands.check(scene); },
                    [commands](const job::Work& work) { return commands.run(work); }});
  // Not before the queue, which keeps other servers away from the data.
  asset::Assets assets(settings.data, settings.asset_space, settings.free_space);
  asset::Uploads uploads(assets, settings.upload_patience);
  const AssetKeeper keeper(queue, assets, settings.keep_assets);
  ApiSettings api_settings;
  api_settings.base = base_of(settings, listener.port());
  api_settings.hosts = hosts_of(settings, listener.port());
  api_settings.viewer = settings.viewer.empty() ? find_viewer() : settings.viewer;
  api_settings.hidden = hidden_of(settings);
  api_settings.roots = commands.roots;
  api_settings.tilesets = tilesets;
  api_settings.scene_schema = scene::schema;
  api_settings.callbacks = AllowList(settings.callbacks, "--callback-allow");
  api_settings.sources = AllowList(settings.sources, "--fetch-allow");
  if (!settings.keys.empty()) api_settings.keys = KeyRing(settings.keys);
  api_settings.draining = [stop = settings.stop] { return stop.stop_requested(); };
  set_log_format(settings.json_log ? LogFormat::json : LogFormat::text);
  api_settings.connections = [&listener] { return listener.connections(); };
  if (settings.listening) settings.listening(listener.port());
  Api api(queue, assets, uploads, std::move(api_settings));
  std::optional<Courier> courier;
  if (sender) courier.emplace(queue, *sender, settings.callback_pause);
  std::stop_source drained;
  std::jthread drain([&](const std::stop_token& over) { wait_to_drain(settings, over, drained); });
  listener.run(
      {[&api](Request request) { return api.answer(std::move(request)); }, &Api::takes_body,
       [&api](Request request, Response& response, Api::Clock::time_point since) {
         api.note(std::move(request), response, since);
       }},
      drained.get_token());
}

}  // namespace hoodoo::http
