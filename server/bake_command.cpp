#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/scene/scene.hpp"
#include "server/commands.hpp"
#include "server/progress_line.hpp"
#include "server/resources.hpp"
#include "server/signals.hpp"
#include "tiling/bake/bake.hpp"

namespace hoodoo {
namespace {

namespace fs = std::filesystem;

struct BakeOptions {
  std::string scene, folder, only, shard, cache, reuse, base, progress = "auto";
  std::vector<std::string> roots;
  Resources resources;
  std::optional<int> draco_speed;
  std::optional<std::uint64_t> most_tiles;
  std::optional<double> most_extent;
  bool force = false, stats = false, plan = false;
  int live_index_ms = 0;
};

ProgressLine::Style style_of(const std::string& name) {
  if (name == "bar") return ProgressLine::Style::bar;
  if (name == "lines") return ProgressLine::Style::lines;
  if (name == "json") return ProgressLine::Style::json;
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
  fmt::print("gen    {:.3f} s from JSON to what generators made, elevations apart\n", s.generation);
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

void report_plan(const bake::Report& report, const std::string& scene, bool as_json) {
  const auto& plan = *report.plan;
  if (as_json) {
    const nlohmann::json json = {{"planned", report.progress.total},
                                 {"levels", plan.tiles},
                                 {"plan_bytes", plan.memory},
                                 {"warnings", report.warnings}};
    fmt::print("{}\n", json.dump());
    return;
  }
  for (const auto& warning : report.warnings) fmt::print(stderr, "hoodoo: warning: {}\n", warning);
  fmt::print("{}: {} tiles in {} levels, {} bytes of plan\n", scene, report.progress.total,
             plan.tiles.size(), plan.memory);
  for (std::size_t level = 0; level < plan.tiles.size(); ++level) {
    fmt::print("level {}: {} tiles\n", level, plan.tiles[level]);
  }
}

int run_bake(const BakeOptions& options, bool as_json) {
  const Signals signals;
  ProgressLine line(style_of(options.progress));
  bake::Settings settings;
  settings.threads = options.resources.threads;
  settings.memory = options.resources.memory_mib << 20;
  settings.force = options.force;
  settings.stats = options.stats;
  settings.most_tiles = options.most_tiles;
  settings.most_extent = options.most_extent;
  settings.plan_only = options.plan;
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
  settings.reuse = options.reuse;
  std::error_code error;
  if (!options.reuse.empty() && !fs::exists(settings.reuse / "bake.json", error)) {
    throw Error(Fault::not_found, options.reuse,
                "holds no bake.json: --reuse takes a bake's folder");
  }
  if (options.live_index_ms > 0) {
    settings.live_index = std::chrono::milliseconds(options.live_index_ms);
  }
  const fs::path file = options.scene;
  auto scene = scene::read(file);
  if (options.draco_speed && scene.is_object()) {
    const auto stated = scene.emplace("bake", nlohmann::json::object()).first;
    // One that is no object is refused with all else that is wrong with the scene.
    if (stated->is_object()) (*stated)["draco_speed"] = *options.draco_speed;
  }
  const auto result =
      bake::run(scene, sources_of(file, options.base, options.roots), options.folder, settings);
  if (result.plan) {
    report_plan(result, options.scene, as_json);
  } else {
    report(result, options.folder, as_json);
  }
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
  command->add_option("--reuse", options->reuse,
                      "Folder of an earlier bake; tiles that would be the same are taken from it");
  command->add_option("--cache", options->cache,
                      "Folder of finished tiles to share between bakes and machines");
  command
      ->add_option("--draco-speed", options->draco_speed,
                   "Instead of the scene's: 0 gives the smallest tiles, 10 takes least time")
      ->check(CLI::Range(0, 10));
  command->add_flag("--plan", options->plan,
                    "Ingest the elevations and plan, and bake nothing: how many tiles of each "
                    "level there are, and what the plan takes in memory");
  command
      ->add_option("--most-tiles", options->most_tiles,
                   "Bake nothing when more tiles than that are planned (exit code 3)")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 48));
  command
      ->add_option("--most-extent", options->most_extent,
                   "Bake nothing when a side of the world is longer than that [m] (exit code 3)")
      ->check(CLI::Range(1e-3, 1e9));
  command->add_flag("--force", options->force, "Bake tiles again that are finished");
  command->add_flag("--stats", options->stats,
                    "Measure the scene, too: the columns of Table 1 of Paris et al. 2019");
  add_sources(*command, &options->base, &options->roots);
  command
      ->add_option("--live-index", options->live_index_ms,
                   "Index what is finished this often [ms], for those who look on; 0: at the end")
      ->check(CLI::Range(0, 3'600'000))
      ->capture_default_str();
  command->add_option("--progress", options->progress, "auto, bar, lines, json or off")
      ->check(CLI::IsMember({"auto", "bar", "lines", "json", "off"}))
      ->capture_default_str();
  command->callback([=, &app] { *exit = run_bake(*options, json_wanted(app)); });
}

}  // namespace hoodoo
