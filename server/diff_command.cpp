#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "server/commands.hpp"
#include "tiling/compare/compare.hpp"

namespace hoodoo {
namespace {

using compare::Comparison;
using compare::Tile;

constexpr std::size_t most_lines = 50;
constexpr std::size_t most_pictures = 6;

struct Options {
  std::string first, second, page;
  double tolerance = 0;
};

/// Whatever keeps two bakes from being compared is one fault to a caller, as with diff(1).
Comparison compared(const Options& options) {
  const compare::Settings settings{options.tolerance, options.page.empty() ? 0 : most_pictures};
  try {
    return compare::compare(options.first, options.second, settings);
  } catch (const Error& error) {
    if (error.fault != Fault::not_found && error.fault != Fault::io) throw;
    throw Error(Fault::bad_input, error.problems);
  }
}

void print_tile(const Tile& tile, bool by_region) {
  if (tile.change != Tile::Change::changed) {
    fmt::print("{:12} {}\n", tile.key.text(),
               tile.change == Tile::Change::added ? "added" : "gone");
    return;
  }
  fmt::print("{:12} largest {:.4g} m, mean {:.3g} m", tile.key.text(), tile.largest, tile.mean);
  if (!by_region) {
    fmt::print(", normals {:.1f} degrees, material {:.2f} %", tile.normal, 100 * tile.material);
  }
  fmt::print("\n");
}

void print_text(const Comparison& found) {
  std::size_t lines = 0;
  for (const auto& tile : found.tiles) {
    if (!tile.beyond) continue;
    if (++lines <= most_lines) print_tile(tile, found.by_region);
  }
  if (lines > most_lines) fmt::print("and {} more\n", lines - most_lines);
  for (const auto& line : compare::summary(found)) fmt::print("{}\n", line);
  fmt::print("{}\n", found.same() ? "same" : "different");
}

int run(const Options& options, bool as_json) {
  if (!std::isfinite(options.tolerance)) {  // CLI11 lets "nan" into any range
    throw Error(Fault::bad_input, "--tolerance", "must be a number of metres in [0, 1000000]");
  }
  const auto found = compared(options);
  if (!options.page.empty()) {
    write_file(options.page, compare::page(found, options.first, options.second));
  }
  if (as_json) {
    fmt::print("{}\n", compare::to_json(found).dump());
  } else {
    print_text(found);
  }
  return found.same() ? 0 : 1;
}

}  // namespace

void add_diff(CLI::App& app, int* exit) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand(
      "diff", "Compare two finished bakes: exit 0 same, 1 different, 2 could not compare");
  command->add_option("first", options->first, "Folder of a tileset")->required();
  command->add_option("second", options->second, "Folder of the other one")->required();
  command
      ->add_option("--tolerance", options->tolerance,
                   "Distance [m] up to which leaves are the same; 2^L times that at level L")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->add_option("--html", options->page, "Write a page with pictures of the worst tiles");
  command->callback([=, &app] { *exit = run(*options, json_wanted(app)); });
}

}  // namespace hoodoo
