#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/base/error.hpp"
#include "server/commands.hpp"
#include "tiling/export/export.hpp"

namespace hoodoo {
namespace {

struct Options {
  std::string folder, file, format, region, voxel, pixel;
  int level = 0;
};

/// The whole of `text` as a finite number.
std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

exporting::Region region_of(const std::string& text) {
  std::array<double, 4> edges{};
  std::string_view rest = text;
  bool good = true;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto comma = rest.find(',');
    const auto value = number(rest.substr(0, comma));
    good = good && value && (comma == rest.npos) == (i + 1 == edges.size());
    edges[i] = value.value_or(0);
    rest.remove_prefix(comma == rest.npos ? rest.size() : comma + 1);
  }
  if (!good || !(edges[0] < edges[2] && edges[1] < edges[3])) {
    throw Error(
        Fault::bad_input, "--region",
        "must be X0,Y0,X1,Y1 in metres of the scene frame with X0 < X1 and Y0 < Y1, got \"" + text +
            "\"");
  }
  return {edges[0], edges[1], edges[2], edges[3]};
}

std::optional<double> side_of(const char* option, const std::string& text) {
  constexpr double least = 1e-4, most = 1e6;
  if (text.empty()) return std::nullopt;
  const auto value = number(text);
  if (!value || !(*value >= least && *value <= most)) {
    throw Error(Fault::bad_input, option,
                fmt::format("must be in [{}, {}] m, got \"{}\"", least, most, text));
  }
  return value;
}

void print(const exporting::Report& report) {
  const auto count = [](std::uint64_t value, const char* what) {
    return value > 0 ? fmt::format(", {} {}", value, what) : "";
  };
  const auto size =
      report.width > 0 ? fmt::format(", {} x {} pixels", report.width, report.height) : "";
  const auto numbers = count(report.tiles, "tiles") + count(report.vertices, "vertices") +
                       count(report.triangles, "triangles") + count(report.voxels, "voxels") +
                       size + count(report.packed, "files");
  std::string names;
  for (const auto& file : report.files) names += (names.empty() ? "" : ", ") + file.string();
  fmt::print("{}: {}\n", names, numbers.substr(2));
}

int run(const Options& options, bool as_json) {
  exporting::Settings settings;
  settings.level = options.level;
  if (!options.region.empty()) settings.region = region_of(options.region);
  settings.voxel = side_of("--voxel", options.voxel);
  settings.pixel = side_of("--pixel", options.pixel);
  const auto format = exporting::format_of(options.file, options.format);
  const auto report = exporting::run(options.folder, options.file, format, settings);
  if (as_json) {
    fmt::print("{}\n", exporting::to_json(report).dump());
  } else {
    print(report);
  }
  return 0;
}

}  // namespace

void add_export(CLI::App& app, int* exit) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand(
      "export",
      "Write a level or region of a finished bake as one OBJ, PLY, glTF, OpenVDB level set or "
      "height map, or the whole as a .3tz archive");
  command->add_option("folder", options->folder, "Folder of the tileset")->required();
  command
      ->add_option("-o,--output", options->file,
                   "File to write: .obj, .ply, .glb, .gltf, .vdb, .png, .tif or .3tz")
      ->required();
  command->add_option("--format", options->format, "Format, where the ending does not tell it");
  command->add_option("--level", options->level, "Level of the tiles, 0 the finest")
      ->capture_default_str();
  command->add_option("--region", options->region,
                      "X0,Y0,X1,Y1 [m] in the scene frame: the tiles that it touches, whole; of a "
                      "height map its pixels");
  command->add_option("--voxel", options->voxel,
                      "Side of a voxel of a VDB [m]; the level's spacing by default");
  command->add_option("--pixel", options->pixel,
                      "Side of a pixel of a height map [m]; the level's spacing by default");
  command->callback([=, &app] { *exit = run(*options, json_wanted(app)); });
}

}  // namespace hoodoo
