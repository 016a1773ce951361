#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "engine/scene/scene.hpp"
#include "server/commands.hpp"
#include "server/http/http.hpp"
#include "server/progress_line.hpp"
#include "server/signals.hpp"
#include "tiling/bake/bake.hpp"

namespace hoodoo {
namespace {

namespace fs = std::filesystem;

int default_threads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

struct Resources {
  int threads = default_threads();
  std::size_t memory_mib = 1024;

  void add_to(CLI::App& command) {
    command.add_option("--threads", threads, "Worker threads")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command.add_option("--memory", memory_mib, "Memory budget [MiB]")
        ->check(CLI::Range(std::size_t{64}, std::size_t{1} << 24))
        ->capture_default_str();
  }
};

struct BakeOptions {
  std::string scene, folder, only, shard, cache, progress = "auto";
  Resources resources;
  std::optional<int> draco_speed;
  bool force = false, stats = false;
};

ProgressLine::Style style_of(const std::string& name) {
  if (name == "bar") return ProgressLine::Style::bar;
  if (name == "lines") return ProgressLine::Style::lines;
  return name == "off" ? ProgressLine::Style::off : ProgressLine::automatic();
}

nlohmann::json to_json(const bake::Statistics& s) {
  return {{"covered", s.covered},
          {"nodes", s.nodes},
          {"generation_s", s.generation},
          {"memory_bytes", s.memory},
          {"grid", s.grid},
          {"t_s", s.seconds},
          {"t0_s", s.all_seconds},
          {"calls", s.calls},
          {"bounded_calls", s.bounded_calls},
          {"calls0", s.all_calls},
          {"tiles", s.tiles},
          {"tiles_measured", s.tiles_measured},
          {"t0_columns_measured", s.columns_asked}};
}

/// The columns of Table 1 of Paris et al. 2019.
void print(const bake::Statistics& s) {
  constexpr double million = 1e6;
  fmt::print("a      {:.3f} of the columns, where a tree can act\n", s.covered);
  fmt::print("#N     {} nodes\n", s.nodes);
  fmt::print("gen    {:.3f} s from JSON to a checked scene\n", s.generation);
  fmt::print("mem    {:.3f} MB of construction tree\n", static_cast<double>(s.memory) / million);
  fmt::print("grid   {} x {} x {} cells\n", s.grid[0], s.grid[1], s.grid[2]);
  fmt::print("t      {:.3f} s for the surface{}\n", s.seconds,
             s.tiles_measured < s.tiles ? fmt::format(" (measured on {} of {} tiles, multiplied)",
                                                      s.tiles_measured, s.tiles)
                                        : "");
  fmt::print("t0     {:.3f} s with pruning off (each call as on {} columns asked, times #C0)\n",
             s.all_seconds, s.columns_asked);
  fmt::print("#C     {:.3f} million calls; {:.3f} million within the bounds of section 7\n",
             static_cast<double>(s.calls) / million,
             static_cast<double>(s.bounded_calls) / million);
  fmt::print("#C0    {:.3f} million calls\n", static_cast<double>(s.all_calls) / million);
}

void report(const bake::Report& report, const std::string& folder, bool as_json) {
  const auto& p = report.progress;
  if (as_json) {
    nlohmann::json json = {{"tiles", p.done},
                           {"planned", p.total},
                           {"reused", p.reused},
                           {"cached", p.cached},
                           {"triangles", p.triangles},
                           {"bytes", p.bytes},
                           {"complete", report.complete},
                           {"warnings", report.warnings}};
    if (report.stats) json["stats"] = to_json(*report.stats);
    fmt::print("{}\n", json.dump());
    return;
  }
  for (const auto& warning : report.warnings) fmt::print(stderr, "hoodoo: warning: {}\n", warning);
  const auto cached = p.cached > 0 ? fmt::format(", {} from the cache", p.cached) : "";
  fmt::print("{}: {} of {} tiles ({} found finished{}), {} triangles, {} bytes{}\n", folder, p.done,
             p.total, p.reused, cached, p.triangles, p.bytes,
             report.complete ? "" : "; not complete yet");
  if (report.stats) print(*report.stats);
}

int run_bake(const BakeOptions& options, bool as_json) {
  const Signals signals;
  ProgressLine line(style_of(options.progress));
  bake::Settings settings;
  settings.threads = options.resources.threads;
  settings.memory = options.resources.memory_mib << 20;
  settings.force = options.force;
  settings.stats = options.stats;
  settings.stop = signals.token();
  settings.progress = [&line](const bake::Progress& p) { line.show(p); };
  if (!options.only.empty()) {
    settings.only = plan::Key::parse(options.only);
    if (!settings.only) {
      throw Error(Fault::bad_input, "--only", "must be L/X/Y, got \"" + options.only + "\"");
    }
  }
  if (!options.shard.empty()) {
    settings.shard = plan::Shard::parse(options.shard);
    if (!settings.shard) {
      throw Error(Fault::bad_input, "--shard",
                  fmt::format("must be i/N with i from 1 to N and N at most {}, got \"{}\"",
                              plan::Shard::most, options.shard));
    }
  }
  settings.cache = options.cache;
  const fs::path file = options.scene;
  auto scene = scene::read(file);
  if (options.draco_speed && scene.is_object()) scene["bake"]["draco_speed"] = *options.draco_speed;
  const auto result = bake::run(scene, {file.parent_path().empty() ? "." : file.parent_path(), {}},
                                options.folder, settings);
  report(result, options.folder, as_json);
  return 0;
}

}  // namespace

void add_bake(CLI::App& app, int* exit) {
  auto options = std::make_shared<BakeOptions>();
  auto* command = app.add_subcommand("bake", "Bake a scene into a tileset");
  command->add_option("scene", options->scene, "The scene file")->required();
  command->add_option("-o,--output", options->folder, "Folder of the tileset")->required();
  options->resources.add_to(*command);
  auto* only = command->add_option("--only", options->only, "Bake this tile alone, L/X/Y");
  command
      ->add_option("--shard", options->shard,
                   "Bake part i of N alone, i/N with i from 1; into the same folder or one of its "
                   "own, for merge")
      ->excludes(only);
  command->add_option("--cache", options->cache,
                      "Folder of finished tiles to share between bakes and machines");
  command
      ->add_option("--draco-speed", options->draco_speed,
                   "Instead of the scene's: 0 gives the smallest tiles, 10 takes least time")
      ->check(CLI::Range(0, 10));
  command->add_flag("--force", options->force, "Bake tiles again that are finished");
  command->add_flag("--stats", options->stats,
                    "Measure the scene, too: the columns of Table 1 of Paris et al. 2019");
  command->add_option("--progress", options->progress, "auto, bar, lines or off")
      ->check(CLI::IsMember({"auto", "bar", "lines", "off"}))
      ->capture_default_str();
  command->callback([=, &app] { *exit = run_bake(*options, json_wanted(app)); });
}

void add_serve(CLI::App& app, int* exit) {
  struct Options {
    std::string listen = "127.0.0.1:8080", data = "hoodoo-data", cache, viewer, public_url;
    std::vector<std::string> roots, tilesets;
    Resources resources;
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
  options->resources.add_to(*command);
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
    settings.viewer = options->viewer;
    settings.public_url = options->public_url;
    settings.stop = signals.token();
    settings.listening = [host = settings.host](int bound) {
      fmt::print("hoodoo: listening on http://{}:{}/\n", host, bound);
      std::fflush(stdout);
    };
    http::serve(settings);
    *exit = 0;
  });
}

}  // namespace hoodoo
