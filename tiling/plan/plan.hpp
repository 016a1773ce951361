#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/hash.hpp"
#include "engine/scene/scene.hpp"

/// tiling/plan: Scene -> tile keys and levels.
namespace hoodoo::plan {

/// One tile: column (x, y) of the quadtree at `level`; level 0 is the finest. A tile covers
/// tile_cells^2 cells in plan and all of z.
struct Key {
  int level = 0;
  std::int64_t x = 0, y = 0;

  std::string text() const;  // "L/X/Y"
  static std::optional<Key> parse(std::string_view text);
  Key parent() const { return {level + 1, x >> 1, y >> 1}; }
  friend auto operator<=>(const Key&, const Key&) = default;
};

/// The lattice anchored at the scene origin: level L has the spacing s_L = 2^L s_0, and vertices
/// stand on multiples of step_L = 2^L step_0. A level that is sampled finer has the samples and
/// steps of a level below it.
struct Lattice {
  double spacing0 = 1;       // s_0 [m], a multiple of step0
  double step0 = 1.0 / 256;  // [m], a power of two
  int tile_cells = 128;
  std::vector<int> finer = {};  // per level: its tiles are sampled at the level so many below it;
                                // of levels beyond the list, and level 0: 0

  int finer_by(int level) const {
    return static_cast<std::size_t>(level) < finer.size() ? finer[static_cast<std::size_t>(level)]
                                                          : 0;
  }
  int units() const { return static_cast<int>(spacing0 / step0); }  // steps per cell, 256 to 511
  double spacing(int level) const { return spacing0 * scale(level); }
  double step(int level) const { return step0 * scale(level - finer_by(level)); }
  /// Of a tile, in steps of its level.
  std::int64_t side(int level) const {
    return (std::int64_t{units()} * tile_cells) << finer_by(level);
  }
  static double scale(int level) { return static_cast<double>(std::int64_t{1} << level); }
  /// Plan box of a tile [m]; z without bounds.
  Box area(const Key& key) const;
};

/// Lattice and key at which a tile is sampled: the tile's own, or those of as many more cells of a
/// finer level over the same area.
struct Sampling {
  Lattice lattice;
  Key key;
};
Sampling sampling_of(const Lattice& lattice, const Key& key);

/// By how many levels each level is sampled finer, for Lattice::finer: one or two, where the scene
/// asks to keep thin features and has one that is thinner than two cells of the level (one cell: by
/// two), but not too thin to be seen at the finer spacing either. Never finer than level 0, nor so
/// that a tile has more than 512 cells along its side.
std::vector<int> finer_levels(const scene::Scene& scene, const Lattice& lattice, int levels);

/// All that is held in memory of one tile, from its planning to the index of the finished bake;
/// what else is known of it stands in its record on disk. Each stage notes what it found.
struct Tile {
  Digest slice;            // once it is cut
  double error = 0;        // geometricError [m]
  std::uint64_t mark = 0;  // the start of a digest, by which stages look for what belongs to it
  std::int32_t x = 0, y = 0;
  std::int8_t level = 0;
  bool ours = false;      // to be baked by this run
  bool finished = false;  // its record is there
  bool empty = false;     // finished, without a surface
  bool covered = false;   // its area is finished, by itself or by all below it
  bool shown = false;     // it or something below it is in the tileset
  bool leaf = false;      // nothing is shown below it
  bool same = false;      // of an earlier index: the same content and error

  Tile() = default;
  explicit Tile(const Key& key)
      : x(static_cast<std::int32_t>(key.x)),
        y(static_cast<std::int32_t>(key.y)),
        level(static_cast<std::int8_t>(key.level)) {}
  Key key() const { return {level, x, y}; }
  bool has_content() const { return finished && !empty; }
};
static_assert(sizeof(Tile) == 64, "what a world costs in memory");

/// The tile of this key among `tiles`, sorted by key; null when it is not planned.
const Tile* find(std::span<const Tile> tiles, const Key& key);
Tile* find(std::span<Tile> tiles, const Key& key);

/// All tiles of a bake.
struct Plan {
  Lattice lattice;
  int levels = 1;
  std::vector<Tile> tiles;  // sorted by key; every tile's parent is there, up to one root
};

/// Plans the tiles that can hold a surface: those over valid elevations, and their ancestors.
/// Errors: limit, when the world has more tiles or levels than can be indexed, or elevations that
/// rise by more cells within a tile than its vertices can be stored for.
Plan make(const scene::Scene& scene);

/// One of `count` parts of a plan, which processes or machines bake apart from each other.
struct Shard {
  std::int64_t index = 1;  // from 1 to count
  std::int64_t count = 1;

  static constexpr std::int64_t most = 1'000'000;            // parts
  static std::optional<Shard> parse(std::string_view text);  // "i/N"
  friend bool operator==(const Shard&, const Shard&) = default;
};

/// Sorts tiles along the Z-order curve (Morton 1966), a tile before those below it.
void sort_along_curve(std::span<Tile> tiles);

/// Makes the tiles of one shard `ours`, and no others. All shards together are all tiles, each
/// once; their numbers differ by at most one. A shard's tiles, of all levels, follow each other on
/// the curve, so that they lie together and share elevations. `tiles` are sorted by key.
void choose(const Shard& shard, std::span<Tile> tiles);

}  // namespace hoodoo::plan
