#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <chrono>
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

void add_serve(CLI::App& app, int* exit) {
  struct Options {
    std::string listen = "127.0.0.1:8080", data = "hoodoo-data", cache, viewer, public_url, keys;
    std::string log = "text";
    int drain = 0;
    std::vector<std::string> roots, tilesets;
    Resources resources;
    int jobs = 1;
    std::size_t most_waiting = 100;
    std::optional<std::size_t> job_memory_mib;
    std::int64_t job_seconds = 0, keep_seconds = 0, upload_seconds = 86400;
    std::uint64_t asset_mib = 65536;
  };
  auto options = std::make_shared<Options>();
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
    settings.at_once = options->jobs;
    settings.most_waiting = options->most_waiting;
    const auto& memory_mib = options->resources.memory_mib;
    settings.limits.memory = options->job_memory_mib.value_or(2 * memory_mib + 512) << 20;
    settings.limits.processor = std::chrono::seconds(options->job_seconds);
    settings.keep = std::chrono::seconds(options->keep_seconds);
    settings.asset_space = options->asset_mib << 20;
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
  command->callback([=] {
    std::vector<http::Scope> scopes;
    for (const auto& name : options->scopes) scopes.push_back(http::scope_of(name));
    fmt::print("{}\n", http::Keys::add(options->file, options->name, scopes));
    *exit = 0;
  });
}

}  // namespace hoodoo
