#include "tiling/slice/slice.hpp"

#include <nlohmann/json.hpp>

namespace hoodoo::slice {
namespace {

using nlohmann::json;

/// How far beyond its area a tile looks: one block for the owners of border points and the
/// thickness under skirts, and two cells for crossings on the far side of those.
constexpr int reach_cells = 18;

json to_json(const Elevations& e) {
  json chunks = json::array();
  for (const auto& digest : e.chunks) chunks.push_back(digest.hex());
  return {{"level", e.level},
          {"grid", {e.grid.x0, e.grid.y0, e.grid.dx, e.grid.dy, e.grid.width, e.grid.height}},
          {"chunks", std::move(chunks)}};
}

}  // namespace

std::string_view engine_version() { return HOODOO_VERSION; }

Box reach(const plan::Lattice& lattice, const plan::Key& key) {
  Box box = lattice.area(key).grown(reach_cells * lattice.spacing(key.level));
  box.min.z = -Box::infinity;
  box.max.z = Box::infinity;
  return box;
}

std::string Slice::bytes() const {
  std::vector<Digest> balls;
  const auto named = tree::without_balls(ground, balls);
  json all = {{"engine", engine_version()},
              {"key", key.text()},
              {"spacing0", lattice.spacing0},
              {"step0", lattice.step0},
              {"tile_cells", lattice.tile_cells},
              {"world", {world.min.x, world.min.y, world.max.x, world.max.y}},
              {"profile", profile},
              {"simplify", simplify},
              {"elevations", json::array()},
              {"ground", tree::to_json(named)}};
  for (const auto& list : balls) all["balls"].push_back(list.hex());
  if (earth) {
    all["earth"] = {earth->crs, earth->unit, earth->origin_x, earth->origin_y, earth->vertical};
  }
  if (floor) all["floor"] = *floor;
  if (profile == "draco" && draco_speed != 5) all["draco_speed"] = draco_speed;
  if (finer != 0) all["finer"] = finer;
  if (tile_triangles != scene::BakeSettings::default_tile_triangles) {
    all["tile_triangles"] = tile_triangles;
  }
  for (const auto& e : elevations) all["elevations"].push_back(to_json(e));
  return all.dump();
}

Slice cut(const scene::Scene& scene, const plan::Lattice& lattice, const plan::Key& key) {
  Slice slice;
  const auto sampling = plan::sampling_of(lattice, key);
  slice.key = sampling.key;
  slice.lattice = sampling.lattice;
  slice.finer = lattice.finer_by(key.level);
  slice.world = scene.extent;
  slice.floor = scene.floor;
  slice.profile = scene.bake.profile;
  slice.draco_speed = scene.bake.draco_speed;
  slice.tile_triangles = scene.bake.tile_triangles;
  slice.simplify = key.level == 0 ? scene.bake.simplify * lattice.spacing0
                                  : scene.bake.simplify_coarse * lattice.spacing(key.level);
  const Box near = reach(slice.lattice, slice.key);
  if (!scene.frame.vertical.empty()) slice.earth = scene.frame;
  for (const auto& pyramid : scene.pyramids) {
    const int level = pyramid->level_for(slice.spacing());
    slice.elevations.push_back(
        {level, pyramid->levels()[static_cast<std::size_t>(level)], pyramid->chunks(level, near)});
  }
  // A finite box tells more: how far single precision can carry an influence grows with the box.
  Box pruned_to = near;
  pruned_to.min.z = scene.extent.min.z - reach_cells * slice.spacing();
  pruned_to.max.z = scene.extent.max.z + reach_cells * slice.spacing();
  slice.ground = tree::prune(scene.ground, pruned_to, slice.spacing() / 2);
  return slice;
}

}  // namespace hoodoo::slice
