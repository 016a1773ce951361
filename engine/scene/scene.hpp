#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <tuple>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/error.hpp"
#include "engine/dem/dem.hpp"
#include "engine/generator/record.hpp"
#include "engine/scene/fields.hpp"
#include "engine/tree/ground.hpp"

/// engine/scene: JSON + Pyramid -> Scene: every value present, in range, in metres, points
/// resolved.
namespace hoodoo::scene {

/// Where a scene may look for files.
struct Sources {
  std::filesystem::path base;                // relative paths start here
  std::vector<std::filesystem::path> roots;  // when not empty, a file must lie below one of these
                                             // (symbolic links followed first)
};

/// "bake" of the scene.
struct BakeSettings {
  std::optional<double> spacing;  // s_0 [m]; none: the first DEM's own
  std::optional<Box> extent;      // x and y [m]; none: everything the terrains cover
  int tile_cells = 128;           // 16 to 512, a multiple of 16
  int levels = 0;                 // 0: until one tile covers the world
  double simplify = 0.1;          // leaves [s_0]; 0: not at all
  double simplify_coarse = 0.5;   // other levels [s_L]
  bool keep_thin = false;         // sample levels finer that would lose a thin feature
  int tile_triangles = default_tile_triangles;  // of one file's surface
  std::string profile = "draco";                // draco | meshopt | plain
  int draco_speed = 5;                          // 0 to 10
  std::string frame = "local";                  // local | ecef
  std::optional<double> base;  // depth of the floor [m]; none: the world is open below
  std::string vertical;        // what heights count from, for ecef; "": what the DEM says

  static constexpr int default_tile_triangles = 262144;

  static constexpr auto fields() {
    using T = BakeSettings;
    using namespace tree;
    return std::tuple{
        OptionalNumber<T>{"spacing", &T::spacing, "m", within(1e-3, longest),
                          "Distance between samples at the finest level; by default the smaller "
                          "ground size of the first DEM's pixels."},
        Special<T, std::optional<Box>>{"extent", &T::extent, extent_form, std::optional<Box>(),
                                       "The part of the world to bake; by default all of it."},
        Whole<T>{"tile_cells", &T::tile_cells, 16, 512, 128,
                 "Cells along a tile's side, a multiple of 16."},
        Whole<T>{"levels", &T::levels, 0, 32, 0,
                 "Levels of detail; 0 is as many as it takes until one tile covers the world."},
        Number<T>{"simplify", &T::simplify, "spacings", within(0, 10), 0.1,
                  "Largest error of simplification at the finest level; 0 is none."},
        Number<T>{"simplify_coarse", &T::simplify_coarse, "spacings", within(0, 10), 0.5,
                  "The same for the other levels, in their own spacings."},
        Flag<T>{"keep_thin", &T::keep_thin, false,
                "Samples a level at a half or a quarter of its spacing where features of the scene "
                "are thinner than two of its cells, so that pillars, arches and thin roofs stay "
                "alive at a distance."},
        Whole<T>{"tile_triangles", &T::tile_triangles, 1000, 16777216, default_tile_triangles,
                 "Triangles of one file's surface; a tile of more is written as several files, one "
                 "above the other."},
        Special<T, std::string>{
            "profile", &T::profile, profile_form, std::string("draco"),
            "Encoding of the tiles: Draco or meshopt compression, or plain glTF."},
        Whole<T>{"draco_speed", &T::draco_speed, 0, 10, 5,
                 "Speed of Draco's encoder: 0 gives the smallest tiles, 10 takes least time."},
        Special<T, std::string>{"frame", &T::frame, frame_form, std::string("local"),
                                "Where the tileset lies: in the scene's own frame, or on the Earth "
                                "(EPSG:4978), every vertex through PROJ."},
        Special<T, std::optional<double>>{
            "base", &T::base, base_form, std::optional<double>(),
            "{\"closed\": depth} closes the surface by walls along the world's edge and around "
            "holes, and by a floor `depth` metres below the lowest elevation; by default the "
            "surface ends at the world's edge."},
        Text<T>{"vertical", &T::vertical, "",
                "With frame \"ecef\", what heights count from: \"ellipsoid\", or a vertical CRS "
                "such as \"EPSG:5773\"; by default what the first DEM states."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
};

/// A scene ready to bake.
struct Scene {
  std::string name;
  std::uint64_t seed = 0;
  dem::Frame frame;
  double spacing = 1;  // s_0 [m], rounded
  BakeSettings bake;
  tree::Ground ground;
  std::vector<std::shared_ptr<const dem::Pyramid>> pyramids;  // one per ground.bodies
  Box extent;                   // of the world [m], z: elevations and influences
  std::optional<double> floor;  // z [m] of the floor that closes the world
  std::vector<std::string> warnings;
  std::vector<generator::Record> grown;        // what each generator did, in their order
  std::set<std::filesystem::path> ball_files;  // in use, by name, beside the pyramids
};

struct OpenSettings {
  std::filesystem::path cache;  // folder for the pyramids and files of balls
  /// Balls of a file that take more [bytes] stay on disk, sorted.
  std::size_t ball_memory = std::size_t{64} << 20;
  dem::IngestSettings ingest;
  bool keep_marks = false;           // of generators, for people
  std::function<void()> checked{};   // called when no problem was seen, before anything is written
  std::function<void()> ingested{};  // called when the elevations are there
};

/// Reads, checks and resolves a scene. Every problem is reported at once, each with its JSON
/// Pointer, value, unit and range; those that need the elevations (a point over a hole) once the
/// rest is right. Errors: bad_input, not_found, limit, io, cancelled.
Scene open(const nlohmann::json& scene, const Sources& sources, const OpenSettings& settings);

/// All problems of a scene that can be seen without ingesting; empty when there are none.
/// Also gives oddities that are no errors in `warnings` when not null.
std::vector<Problem> check(const nlohmann::json& scene, const Sources& sources,
                           std::vector<Problem>* warnings = nullptr);

/// Reads a scene file with the limits of section 9. Errors as parse_json, not_found, io.
nlohmann::json read(const std::filesystem::path& file);

/// JSON Schema (draft 2020-12) of a scene, generated from the types.
nlohmann::json schema();

}  // namespace hoodoo::scene
