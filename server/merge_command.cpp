#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "server/commands.hpp"
#include "server/signals.hpp"
#include "tiling/bake/merge.hpp"

namespace hoodoo {
namespace {

/// Missing tiles are named up to this many; bake.json and --json name all.
constexpr std::size_t most_named = 100;

void report(const bake::MergeReport& report, const std::string& folder, bool as_json) {
  if (as_json) {
    nlohmann::json missing = nlohmann::json::array();
    for (const auto& key : report.missing) missing.push_back(key.text());
    const nlohmann::json json = {{"tiles", report.tiles},
                                 {"planned", report.tiles + report.missing.size()},
                                 {"copied", report.copied},
                                 {"complete", report.missing.empty()},
                                 {"missing", std::move(missing)}};
    fmt::print("{}\n", json.dump());
    return;
  }
  for (std::size_t i = 0; i < std::min(report.missing.size(), most_named); ++i) {
    fmt::print(stderr, "hoodoo: {}: tile {} is missing\n", folder, report.missing[i].text());
  }
  if (report.missing.size() > most_named) {
    fmt::print(stderr, "hoodoo: and {} more\n", report.missing.size() - most_named);
  }
  fmt::print("{}: {} of {} tiles, {} copied{}\n", folder, report.tiles,
             report.tiles + report.missing.size(), report.copied,
             report.missing.empty() ? "" : "; not complete yet");
}

}  // namespace

void add_merge(CLI::App& app, int* exit) {
  struct Options {
    std::vector<std::string> parts;
    std::string folder;
    int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  };
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("merge", "Join bakes of shards into one tileset");
  command->add_option("parts", options->parts, "Folders of the shards")->required();
  command->add_option("-o,--output", options->folder, "Folder of the tileset")->required();
  command->add_option("--threads", options->threads, "Worker threads")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->callback([=, &app] {
    const Signals signals;
    bake::MergeSettings settings{options->threads, signals.token()};
    const auto merged =
        bake::merge({options->parts.begin(), options->parts.end()}, options->folder, settings);
    report(merged, options->folder, json_wanted(app));
    *exit = merged.missing.empty() ? 0 : 1;
  });
}

}  // namespace hoodoo
