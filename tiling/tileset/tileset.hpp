#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "engine/dem/dem.hpp"
#include "engine/tree/ground.hpp"
#include "tiling/plan/plan.hpp"

/// tiling/tileset: finished tiles -> measured geometricError, tileset index, bake.json.
namespace hoodoo::tileset {

/// What is known of one finished tile: a function of its slice alone.
struct Record {
  plan::Key key;
  Digest slice;
  bool empty = false;  // no surface in it: no file
  Digest content;
  std::uint64_t bytes = 0, vertices = 0, triangles = 0, skirt_triangles = 0;
  Box box;                        // of surface and skirt [m], scene frame
  double simplification = 0;      // measured [m]
  std::uint64_t world_edges = 0;  // edges of the surface that end at the world's edge or a hole
  std::map<std::string, std::uint64_t> materials;  // triangles by name

  friend bool operator==(const Record&, const Record&) = default;
};
nlohmann::json to_json(const Record& record);
Record record_from_json(const nlohmann::json& json, const std::string& where);

/// What the index says of the whole.
struct Bake {
  std::string engine;  // release string
  std::string scene_name;
  Digest scene;                    // of the resolved scene
  std::vector<Digest> elevations;  // of the pyramids it looks at
  dem::Frame frame;
  plan::Lattice lattice;
  int levels = 1;
  std::vector<plan::Key> planned;
  std::vector<tree::Material> materials;
  std::vector<Record> records;  // finished tiles, any order

  bool complete() const { return records.size() == planned.size(); }
};

/// Measures every tile's geometricError from the finished files, bottom-up: two-sided distance
/// between a tile's surface and its children's, plus the spacing of the samples it was measured
/// with, plus the largest error among the children, plus one step; leaves have 0. Values already
/// in `folder`/bake.json for the same contents are taken over.
std::map<plan::Key, double> measure_errors(const Bake& bake, const std::filesystem::path& folder,
                                           int threads, std::stop_token stop = {});

/// What stands in for measured errors as long as tiles are missing. A complete index, whose errors
/// a later one may take over, never holds them.
std::map<plan::Key, double> estimate_errors(const Bake& bake);

/// Writes the external tilesets, bake.json, and tileset.json last, and removes index files that
/// are no longer referred to. Returns the relative paths of every file the index needs.
/// An incomplete set of records gives an index of what there is, marked so in bake.json.
std::vector<std::filesystem::path> write_index(const Bake& bake,
                                               const std::map<plan::Key, double>& errors,
                                               const std::filesystem::path& folder);

/// All that the index in `folder` says of its bake, complete or not: `write_index` of it writes the
/// same index. Errors: not_found, io, limit, bad_input naming the file.
Bake read_bake(const std::filesystem::path& folder);

/// One thing a verification found wrong, or nothing.
struct Verification {
  std::vector<Problem> problems;
  std::uint64_t tiles = 0, triangles = 0, border_vertices = 0, open_edges = 0;
  std::map<int, std::int64_t> euler;  // Euler characteristic of each level, welded
};
/// Checks a finished bake as a stranger would: every file there with its hash, boxes hold their
/// contents and their children's, errors fall from parent to child, decoded borders of neighbours
/// of one level agree to the bit (positions and normals), every level welded has two faces on each
/// edge except along the world's edge, nothing degenerate or doubled.
/// Errors: not_found, bad_input when it is no bake at all.
Verification verify(const std::filesystem::path& folder);

}  // namespace hoodoo::tileset
