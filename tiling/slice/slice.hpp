#pragma once
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/hash.hpp"
#include "engine/dem/dem.hpp"
#include "engine/scene/scene.hpp"
#include "engine/tree/ground.hpp"
#include "tiling/plan/plan.hpp"

/// tiling/slice: Scene + tile key -> Slice: all that one tile's bytes depend on.
namespace hoodoo::slice {

/// The elevations one body brings to a tile.
struct Elevations {
  int level = 0;  // of the body's pyramid
  dem::Pyramid::Level grid;
  std::vector<Digest> chunks;  // in reach of the tile
};

/// The only input of a tile. Equal slices give equal bytes, everywhere.
struct Slice {
  plan::Key key;          // at which the tile is sampled: its own, or of a finer level
  plan::Lattice lattice;  // likewise
  int finer = 0;          // levels from the tile's own down to that one
  Box world;              // x and y of the world [m]
  std::string profile;    // draco | meshopt | plain
  int draco_speed = 5;
  double simplify = 0;  // largest error of simplification [m]; 0: none
  int tile_triangles = scene::BakeSettings::default_tile_triangles;  // of one file's surface
  std::optional<double> floor;         // z [m], where walls and a floor close the world
  std::optional<dem::Frame> earth;     // where the tiles lie on the Earth
  std::vector<Elevations> elevations;  // one per ground.bodies
  tree::Ground ground;                 // pruned to `reach`

  plan::Key tile() const { return {key.level + finer, key.x, key.y}; }
  double spacing() const { return lattice.spacing(key.level); }
  double step() const { return lattice.step(key.level); }
  /// Everything above and the engine version, as canonical JSON text.
  std::string bytes() const;
  Digest hash() const { return sha256(bytes()); }
};

/// All that a tile looks at [m]: its area and one block around it; z without bounds.
Box reach(const plan::Lattice& lattice, const plan::Key& key);

/// Cuts the slice of one tile. `pyramids` of the scene are read for digests and bounds only.
Slice cut(const scene::Scene& scene, const plan::Lattice& lattice, const plan::Key& key);

/// The release string; part of every slice.
std::string_view engine_version();

}  // namespace hoodoo::slice
