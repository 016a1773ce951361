#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "engine/dem/raster.hpp"
#include "engine/scene/picture.hpp"
#include "engine/scene/reference.hpp"
#include "engine/scene/sample.hpp"
#include "engine/scene/scene.hpp"
#include "server/commands.hpp"
#include "server/http/openapi.hpp"
#include "server/resources.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json to_json(const std::vector<Problem>& problems) {
  json list = json::array();
  for (const auto& p : problems) list.push_back({{"where", p.where}, {"what", p.what}});
  return list;
}

/// A flat object as aligned "key  value" lines.
void print_table(const json& object) {
  std::size_t width = 0;
  for (const auto& item : object.items()) width = std::max(width, item.key().size());
  for (const auto& item : object.items()) {
    const auto& v = item.value();
    fmt::print("{:{}}  {}\n", item.key(), width, v.is_string() ? v.get<std::string>() : v.dump());
  }
}

json describe_bake(const fs::path& folder) {
  tileset::ManifestReader bake(folder);
  std::uint64_t tiles = 0, triangles = 0, bytes = 0;
  double error = 0;
  while (const auto entry = bake.next()) {
    if (entry->missing) continue;
    ++tiles;
    triangles += entry->record.triangles;
    bytes += entry->record.bytes;
    error = std::max(error, entry->error);
  }
  json result = bake.document();
  result["kind"] = "bake";
  result["tiles"] = tiles;
  result["triangles"] = triangles;
  result["bytes"] = bytes;
  result["largest geometricError"] = error;
  return result;
}

json describe_tile(const fs::path& path) {
  const auto text = read_file(path, std::size_t{1} << 32);
  const auto bytes = std::as_bytes(std::span(text));
  const auto tile = glb::read({bytes.begin(), bytes.end()}, 0, path.string());
  return {{"kind", "tile"},
          {"bytes", text.size()},
          {"step", tile.step},
          {"vertices", tile.surface.points.size()},
          {"triangles", tile.surface.triangles.size()},
          {"skirt triangles", tile.skirt.triangles.size()},
          {"origin",
           {static_cast<double>(tile.origin[0]) * tile.step,
            static_cast<double>(tile.origin[1]) * tile.step,
            static_cast<double>(tile.origin[2]) * tile.step}}};
}

json describe(const fs::path& path) {
  if (fs::is_directory(path)) return describe_bake(path);
  if (path.extension() == ".glb") return describe_tile(path);
  auto info = dem::to_json(dem::Raster::open(path)->info());
  info["kind"] = "dem";
  return info;
}

int check(const std::string& file, const scene::Sources& sources, bool as_json) {
  std::vector<Problem> warnings;
  const auto problems = scene::check(scene::read(file), sources, &warnings);
  if (as_json) {
    const json result = {{"problems", to_json(problems)}, {"warnings", to_json(warnings)}};
    fmt::print("{}\n", result.dump());
  } else {
    for (const auto& w : warnings) fmt::print("warning: {}: {}\n", w.where, w.what);
    for (const auto& p : problems) fmt::print("{}: {}\n", p.where, p.what);
    if (problems.empty()) fmt::print("{}: no problem\n", file);
  }
  return problems.empty() ? 0 : 2;
}

int verify(const std::string& folder, bool as_json) {
  const auto found = tileset::verify(folder);
  if (as_json) {
    json euler = json::object();
    for (const auto& level : found.euler) euler[std::to_string(level.first)] = level.second;
    const json result = {
        {"problems", to_json(found.problems)}, {"tiles", found.tiles},
        {"triangles", found.triangles},        {"borderVertices", found.border_vertices},
        {"openEdges", found.open_edges},       {"euler", euler}};
    fmt::print("{}\n", result.dump());
  } else {
    for (const auto& p : found.problems) fmt::print("{}: {}\n", p.where, p.what);
    fmt::print(
        "{}: {} tiles, {} triangles, {} shared border vertices, {} edges on the world's edge\n",
        folder, found.tiles, found.triangles, found.border_vertices, found.open_edges);
    for (const auto& level : found.euler) {
      fmt::print("level {}: Euler characteristic {}\n", level.first, level.second);
    }
    fmt::print("{}\n", found.problems.empty() ? "verified"
                                              : fmt::format("{} problems", found.problems.size()));
  }
  return found.problems.empty() ? 0 : 1;
}

}  // namespace

void add_check(CLI::App& app, int* exit) {
  struct Options {
    std::string file, base;
    std::vector<std::string> roots;
  };
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("check", "List every problem of a scene");
  command->add_option("scene", options->file, "The scene file")->required();
  add_sources(*command, &options->base, &options->roots);
  command->callback([=, &app] {
    const auto sources = sources_of(options->file, options->base, options->roots);
    *exit = check(options->file, sources, json_wanted(app));
  });
}

void add_verify(CLI::App& app, int* exit) {
  auto folder = std::make_shared<std::string>();
  auto* command =
      app.add_subcommand("verify", "Check index, hashes, borders and manifoldness of a bake");
  command->add_option("folder", *folder, "Folder of the tileset")->required();
  command->callback([=, &app] { *exit = verify(*folder, json_wanted(app)); });
}

void add_info(CLI::App& app, int* exit) {
  auto path = std::make_shared<std::string>();
  auto* command = app.add_subcommand("info", "Say what a DEM, a tile or a bake is");
  command->add_option("path", *path, "A GeoTIFF, a .glb, or the folder of a bake")->required();
  command->callback([=, &app] {
    const auto info = describe(*path);
    if (json_wanted(app)) {
      fmt::print("{}\n", info.dump());
    } else {
      print_table(info);
    }
    *exit = 0;
  });
}

void add_schema(CLI::App& app, int* exit) {
  const std::map<std::string, std::string (*)()> schemas{
      {"scene", [] { return scene::schema().dump(2) + "\n"; }},
      {"nodes", scene::node_reference},
      {"tools", scene::tool_reference},
      {"openapi", [] { return http::openapi("http://127.0.0.1:8080").dump(2) + "\n"; }}};
  auto which = std::make_shared<std::string>("scene");
  auto* command = app.add_subcommand(
      "schema", "Print the JSON Schema of a scene, the API's document, or a reference page");
  command
      ->add_option(
          "which", *which,
          "scene; openapi, of the HTTP API; or the reference of nodes, or of tools: brushes "
          "and generators")
      ->check(CLI::IsMember(schemas))
      ->capture_default_str();
  command->callback([=] {
    fmt::print("{}", schemas.at(*which)());
    *exit = 0;
  });
}

void add_draw(CLI::App& app, int* exit) {
  struct Options {
    std::string tree, output;
    bool geology = false;
    int size = 256;
  };
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("draw", "Draw one construction tree as a PNG");
  command->add_option("tree", options->tree, "The tree's JSON")->required();
  command->add_option("-o,--output", options->output, "The PNG to write")->required();
  command->add_flag("--geology", options->geology, "Draw resistance instead of the surface");
  command->add_option("--size", options->size, "Pixels along a side")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  command->callback([=] {
    const auto family = options->geology ? tree::Family::geology : tree::Family::terrain;
    const auto tree = scene::read_tree(scene::read(options->tree), family,
                                       std::filesystem::path(options->tree).parent_path());
    scene::write_png(scene::draw(tree, family, options->size), options->output);
    *exit = 0;
  });
}

void add_synthesize(CLI::App& app, int* exit) {
  auto file = std::make_shared<std::string>();
  auto sample = std::make_shared<scene::SampleDem>();
  auto* command = app.add_subcommand(
      "synthesize", "Write the sample DEM: a plateau, a cliff, a spur and a valley by the sea");
  command->add_option("file", *file, "The GeoTIFF to write")->required();
  command->add_option("--pixels", sample->pixels, "Pixels per side")
      ->check(CLI::Range(16, 40000))
      ->capture_default_str();
  command->add_option("--spacing", sample->spacing, "Pixel size [m]")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  command->add_option("--seed", sample->seed, "Another seed, another shore")->capture_default_str();
  command->callback([=] {
    scene::write_sample_dem(*file, *sample);
    *exit = 0;
  });
}

}  // namespace hoodoo
