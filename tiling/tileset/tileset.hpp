#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
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

/// One of the files of a tile that is written as several, one above the other.
struct Slab {
  Digest content;
  std::uint64_t bytes = 0, vertices = 0, triangles = 0, skirt_triangles = 0;
  Box box;  // of surface and skirt [m], as of the tile

  friend bool operator==(const Slab&, const Slab&) = default;
};

/// What is known of one finished tile: a function of its slice alone.
struct Record {
  plan::Key key;
  Digest slice;
  bool empty = false;  // no surface in it: no file
  Digest content;      // of its file, or of its slabs' digests one after another
  std::uint64_t bytes = 0, vertices = 0, triangles = 0, skirt_triangles = 0;
  Box box;                        // of surface and skirt [m], scene frame
  double simplification = 0;      // measured [m]
  std::uint64_t world_edges = 0;  // edges of the surface that end at the world's edge or a hole
  std::map<std::string, std::uint64_t> materials;  // triangles by name
  std::vector<Slab> slabs;  // lowest first, two or more; none where the tile is one file

  /// Its files: its slabs, or the tile itself; none when it is empty.
  std::vector<Slab> files() const;
  friend bool operator==(const Record&, const Record&) = default;
};
/// Gives a record what is told by its files: one, or slabs in their order.
void set_files(Record& record, std::vector<Slab> files);
nlohmann::json to_json(const Record& record);
Record record_from_json(const nlohmann::json& json, const std::string& where);

/// What the index says of the whole.
struct Header {
  std::string engine;  // release string
  std::string scene_name;
  Digest scene;                    // of the resolved scene
  std::vector<Digest> elevations;  // of the pyramids it looks at
  dem::Frame frame;
  plan::Lattice lattice;
  int levels = 1;
  std::vector<tree::Material> materials;
};

/// An index in the making: what is held in memory of each tile, and where its record is found.
struct Index : Header {
  std::vector<plan::Tile> tiles;                    // planned, by key
  std::function<Record(const plan::Tile&)> read{};  // the record of one that is finished

  bool complete() const { return finished() == tiles.size(); }
  std::size_t finished() const;
};

/// Measures every tile's geometricError from the finished files, bottom-up: two-sided distance
/// between a tile's surface and its children's (at most 1.8 of the children's spacings too
/// large, and never too small), plus the largest error among the children, plus one step; leaves
/// have 0. So it is no less than the distance to the leaves. Values already in `folder`/bake.json
/// for the same contents are taken over.
void measure_errors(Index& index, const std::filesystem::path& folder, int threads,
                    std::stop_token stop = {});

/// What stands in for measured errors as long as tiles are missing. A complete index, whose errors
/// a later one may take over, never holds them.
void estimate_errors(Index& index);

struct IndexSettings {
  /// bake.json of a plan of more tiles has a line for each, else it is one document.
  std::size_t lines_past = 10'000;
};

/// What was written.
struct Written {
  std::vector<std::filesystem::path> files;  // the index, by path relative to the folder
  std::uint64_t tiles = 0, triangles = 0, bytes = 0;
  std::vector<std::uint64_t> slabs;  // starts of the digests of tiles' slabs
};

/// Writes the external tilesets, bake.json, and tileset.json last, and removes index files that
/// are no longer referred to. An incomplete set of tiles gives an index of what there is, marked so
/// in bake.json. Leaves in each tile's `mark` the start of its content's digest.
Written write_index(Index& index, const std::filesystem::path& folder,
                    const IndexSettings& settings = {});

/// A bake with all its records in memory, about 400 bytes a tile.
struct Bake : Header {
  std::vector<plan::Key> planned;
  std::vector<Record> records;  // finished tiles, any order

  bool complete() const { return records.size() == planned.size(); }
};

/// All that the index in `folder` says of its bake, complete or not: `write_index` of it writes the
/// same index. Errors: not_found, io, limit, bad_input naming the file.
Bake read_bake(const std::filesystem::path& folder);

/// One thing a verification found wrong, or nothing.
struct Verification {
  std::vector<Problem> problems;
  std::uint64_t tiles = 0, triangles = 0, border_vertices = 0, open_edges = 0;
  std::map<int, std::int64_t> euler;  // Euler characteristic of each level, welded
};
/// Checks a finished bake as a stranger would: every file there with its hash and none that no
/// index names (but for those of a run at work), boxes hold their contents and their children's,
/// errors fall from parent to child, decoded borders of neighbours of one level agree to the bit
/// (positions and normals), every level welded has two faces on each edge except along the world's
/// edge, nothing degenerate or doubled. Errors: not_found, bad_input when it is no bake at all.
Verification verify(const std::filesystem::path& folder);

}  // namespace hoodoo::tileset
