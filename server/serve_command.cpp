#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "engine/base/error.hpp"
#include "server/commands.hpp"
#include "server/http/http.hpp"
#include "server/http/keys.hpp"
#include "server/resources.hpp"
#include "server/signals.hpp"

namespace hoodoo {

namespace {

struct ServeOptions {
  std::string listen = "127.0.0.1:8080", data = "hoodoo-data", cache, viewer, public_url, keys;
  std::string log = "text";
  int drain = 0;
  std::vector<std::string> roots, tilesets;
  Resources resources;
  int jobs = 1;
  std::size_t connections = 4096;
  std::size_t most_waiting = 100;
  std::optional<std::size_t> job_memory_mib;
  std::int64_t job_seconds = 0, keep_seconds = 0, upload_seconds = 86400;
  std::uint64_t asset_mib = 65536, free_mib = 64;
  std::int64_t keep_assets = 0;
  std::vector<std::string> callbacks, sources;
  std::string callback_secret;
  double callback_seconds = 10;
};

void add_callbacks(CLI::App& command, ServeOptions& options) {
  command.add_option(
      "--callback-allow", options.callbacks,
      "HOST[:PORT] that jobs may name as a subscriber; without a port the usual one. "
      "An address that is not public must be named itself. None: no callbacks");
  command.add_option("--fetch-allow", options.sources,
                     "HOST[:PORT] that elevations may be fetched from, as for --callback-allow. "
                     "None: nothing is fetched");
  command.add_option("--callback-secret", options.callback_secret,
                     "File of the secret that callbacks are signed with; needed with "
                     "--callback-allow");
  command
      .add_option(
          "--callback-seconds", options.callback_seconds,
          "Pause [s] after the first try of a callback; twice as long after each further one")
      ->check(CLI::Range(0.01, 86400.0))
      ->capture_default_str();
}

}  // namespace

void add_serve(CLI::App& app, int* exit) {
  auto options = std::make_shared<ServeOptions>();
  auto* command = app.add_subcommand("serve", "Serve bake jobs, their tiles and the viewer");
  command->add_option("--listen", options->listen, "HOST:PORT; port 0 takes a free one")
      ->capture_default_str();
  command->add_option("--data", options->data, "Folder of jobs and results")->capture_default_str();
  command->add_option("--cache", options->cache,
                      "Folder of finished tiles to share between bakes and machines");
  command->add_option("--root", options->roots, "Folder below which a scene may find its DEMs");
  command->add_option("--tileset", options->tilesets,
                      "Folder or .3tz archive of a finished tileset to stream as /tilesets/NAME/, "
                      "which pages of any origin may read");
  command->add_option("--viewer", options->viewer, "Folder of the viewer's files");
  command->add_option("--public-url", options->public_url, "What clients reach this server as");
  command->add_option("--keys", options->keys,
                      "File of bearer keys, as `hoodoo key` writes it; needed where others can "
                      "reach the server");
  command->add_option("--log", options->log, "On stderr: faults as text, or JSON lines of requests")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  command
      ->add_option("--drain", options->drain,
                   "How long [s] after SIGTERM requests are still answered while /readyz is 503")
      ->check(CLI::Range(0, 3600))
      ->capture_default_str();
  options->resources.add_to(*command);
  command
      ->add_option("--connections", options->connections,
                   "Connections at once, at most a third of the files that the process may open; "
                   "beyond, the one goes that has waited longest for a request")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 16))
      ->capture_default_str();
  command->add_option("--jobs", options->jobs, "Jobs that run at once")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_option("--queue", options->most_waiting, "Jobs that may wait")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--job-memory", options->job_memory_mib,
                      "Most memory [MiB] of a job's process; 0: no limit. Default: twice --memory "
                      "and 512 more");
  command
      ->add_option("--job-seconds", options->job_seconds,
                   "Most processor time [s] of a job, of all threads together; 0: no limit")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 31))
      ->capture_default_str();
  command
      ->add_option("--keep-seconds", options->keep_seconds,
                   "How long [s] a job that has ended is kept with its results; 0: until somebody "
                   "deletes it")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 31))
      ->capture_default_str();
  command
      ->add_option("--asset-space", options->asset_mib,
                   "Most space [MiB] of all assets that clients have sent, and of one")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 40))
      ->capture_default_str();
  add_callbacks(*command, *options);
  command
      ->add_option("--free-space", options->free_mib,
                   "Space [MiB] of the disk that stays free: below it no jobs and assets are taken")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 40))
      ->capture_default_str();
  command
      ->add_option("--keep-assets", options->keep_assets,
                   "How long [s] an asset is kept that no job uses; 0: until somebody deletes it")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 31))
      ->capture_default_str();
  command
      ->add_option("--upload-seconds", options->upload_seconds,
                   "How long [s] an upload is kept that nothing is added to")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 31))
      ->capture_default_str();
  command->callback([=] {
    const Signals signals;
    const auto colon = options->listen.rfind(':');
    int port = -1;
    if (colon != std::string::npos) {
      const auto digits = options->listen.substr(colon + 1);
      const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), port);
      if (read.ptr != digits.data() + digits.size()) port = -1;
    }
    if (port < 0 || port > 65535) {
      throw Error(Fault::bad_input, "--listen",
                  "must be HOST:PORT with a port in [0, 65535], got \"" + options->listen + "\"");
    }
    http::Settings settings;
    settings.host = options->listen.substr(0, colon);
    settings.port = port;
    settings.data = options->data;
    for (const auto& root : options->roots) settings.roots.emplace_back(root);
    for (const auto& tileset : options->tilesets) settings.tilesets.emplace_back(tileset);
    settings.threads = options->resources.threads;
    settings.memory = options->resources.memory_mib << 20;
    settings.cache = options->cache;
    settings.connections = options->connections;
    settings.at_once = options->jobs;
    settings.most_waiting = options->most_waiting;
    const auto& memory_mib = options->resources.memory_mib;
    settings.limits.memory = options->job_memory_mib.value_or(2 * memory_mib + 512) << 20;
    settings.limits.processor = std::chrono::seconds(options->job_seconds);
    settings.keep = std::chrono::seconds(options->keep_seconds);
    settings.asset_space = options->asset_mib << 20;
    settings.free_space = options->free_mib << 20;
    settings.keep_assets = std::chrono::seconds(options->keep_assets);
    settings.callbacks = options->callbacks;
    settings.sources = options->sources;
    settings.callback_secret = options->callback_secret;
    settings.callback_pause =
        std::chrono::milliseconds(std::llround(1e3 * options->callback_seconds));
    settings.upload_patience = std::chrono::seconds(options->upload_seconds);
    settings.program = std::filesystem::read_symlink("/proc/self/exe");
    settings.viewer = options->viewer;
    settings.public_url = options->public_url;
    settings.keys = options->keys;
    settings.json_log = options->log == "json";
    settings.drain = std::chrono::seconds(options->drain);
    settings.stop = signals.token();
    settings.listening = [host = settings.host](int bound) {
      fmt::print("hoodoo: listening on http://{}:{}/\n", host, bound);
      std::fflush(stdout);
    };
    http::serve(settings);
    *exit = 0;
  });
}

void add_key(CLI::App& app, int* exit) {
  struct Options {
    std::string file, name;
    std::vector<std::string> scopes{"read", "submit"};
    job::Quota quota;
    std::optional<std::uint64_t> most_mib;
  };
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("key", "Make a bearer key for `hoodoo serve --keys`");
  command->add_option("file", options->file, "File of keys; made when absent")->required();
  command->add_option("name", options->name, "Whose key it is; an older one of the name goes")
      ->required();
  command
      ->add_option("--scopes", options->scopes,
                   "read: lists; submit: jobs and their end; admin: all of that for every owner's "
                   "jobs, and /metrics")
      ->delimiter(',')
      ->check(CLI::IsMember({"read", "submit", "admin"}))
      ->capture_default_str();
  const CLI::Range some(std::uint64_t{1}, std::uint64_t{1} << 40);
  command
      ->add_option("--most-jobs", options->quota.jobs,
                   "Most jobs of the key that wait or run; else 50 that wait")
      ->check(some);
  command
      ->add_option("--most-space", options->most_mib,
                   "Most space [MiB] of its assets and of its jobs that have ended")
      ->check(some);
  command->add_option("--most-tiles", options->quota.bake.tiles, "Most tiles of a bake")
      ->check(some);
  command
      ->add_option("--most-extent", options->quota.bake.extent,
                   "Longest side of the world of a bake [m]")
      ->check(CLI::Range(1e-3, 1e9));
  command->callback([=] {
    std::vector<http::Scope> scopes;
    for (const auto& name : options->scopes) scopes.push_back(http::scope_of(name));
    auto quota = options->quota;
    if (options->most_mib) quota.bytes = *options->most_mib << 20;
    fmt::print("{}\n", http::Keys::add(options->file, options->name, scopes, quota));
    *exit = 0;
  });
}

}  // namespace hoodoo
