#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "engine/scene/scene.hpp"
#include "tiling/plan/plan.hpp"

namespace hoodoo::bake {

/// What Table 1 of Paris et al. 2019 tells of a scene, for its finest level.
///
/// Times are of the processor, on one thread. What a tile has is measured on at most `most_tiles`
/// tiles spread over the level and multiplied up to all of them; with so few tiles or fewer nothing
/// is multiplied but t0.
struct Statistics {
  static constexpr std::size_t most_tiles = 256;

  double covered = 0;        // a: share of columns over which a tree can act [0, 1]
  std::uint64_t nodes = 0;   // #N, each ball of a list counted
  double generation = 0;     // from JSON to what generators made, elevations apart [s]
  std::uint64_t memory = 0;  // of the construction tree, elevations and voxels apart [bytes]
  std::array<std::int64_t, 3> grid{};  // cells; z from the lowest to the highest of elevations and
                                       // trees
  double seconds = 0;                  // t: slices cut, field, crossings and surface
  /// #C: points at which the field was asked for that: grid points, root finding, normals, and
  /// Newton's steps of vertices to the surface. Where the height field alone rules it is not asked:
  /// of a block of 16^3 grid points those count at whose row of sixteen along z a primitive is
  /// asked.
  std::uint64_t calls = 0;
  /// Points within the paper's bounds: per column of lattice points from the lowest to the highest
  /// that it or one beside it can have a surface at, and one above.
  std::uint64_t bounded_calls = 0;
  std::uint64_t all_calls = 0;  // #C0: every point of the grid
  /// t0: that many calls of a field compiled for the whole scene at once. Measured on
  /// `columns_asked` columns, from bottom to top, and multiplied up.
  double all_seconds = 0;
  std::uint64_t columns_asked = 0;
  std::uint64_t tiles = 0, tiles_measured = 0;
};

/// Measures `scene`, whose finest tiles are those of level 0 in `planned`. `generation` is left at
/// 0.
Statistics measure_scene(const scene::Scene& scene, const plan::Lattice& lattice,
                         std::span<const plan::Tile> planned);

}  // namespace hoodoo::bake
