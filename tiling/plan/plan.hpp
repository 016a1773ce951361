#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/box.hpp"
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
/// stand on multiples of step_L = 2^L step_0.
struct Lattice {
  double spacing0 = 1;       // s_0 [m], a multiple of step0
  double step0 = 1.0 / 256;  // [m], a power of two
  int tile_cells = 128;

  int units() const { return static_cast<int>(spacing0 / step0); }  // steps per cell, 256 to 511
  double spacing(int level) const { return spacing0 * scale(level); }
  double step(int level) const { return step0 * scale(level); }
  static double scale(int level) { return static_cast<double>(std::int64_t{1} << level); }
  /// Plan box of a tile [m]; z without bounds.
  Box area(const Key& key) const;
};

/// All tiles of a bake.
struct Plan {
  Lattice lattice;
  int levels = 1;
  std::vector<Key> tiles;  // sorted; every tile's parent is there, up to one root
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

/// The tiles of one shard. All shards together are all tiles, each once; their numbers differ by at
/// most one. A shard's tiles, of all levels, follow each other on the Z-order curve (Morton 1966),
/// a tile before those below it, so that they lie together and share elevations.
std::vector<Key> tiles_of(const Shard& shard, std::span<const Key> tiles);

}  // namespace hoodoo::plan
