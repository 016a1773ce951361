#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/tree/ground.hpp"
#include "tiling/plan/plan.hpp"

namespace hoodoo::plan {
namespace {

constexpr int most_cells = 512;  // along a tile's side, as for `tile_cells`
constexpr int most_finer = 2;    // levels

/// Whether leaving out what is thinner takes more from a scene than leaving out what is thinnest.
class Thin {
 public:
  explicit Thin(const scene::Scene& scene) : scene_(scene) {}

  bool any_between(double thinnest, double thinner) const {
    return text(thinnest) != text(thinner);
  }

 private:
  std::string text(double thinnest) const {
    return tree::to_json(tree::prune(scene_.ground, scene_.extent, thinnest)).dump();
  }

  const scene::Scene& scene_;
};

}  // namespace

Sampling sampling_of(const Lattice& lattice, const Key& key) {
  const int finer = lattice.finer_by(key.level);
  return {{lattice.spacing0, lattice.step0, lattice.tile_cells << finer, {}},
          {key.level - finer, key.x, key.y}};
}

std::vector<int> finer_levels(const scene::Scene& scene, const Lattice& lattice, int levels) {
  if (!scene.bake.keep_thin) return {};
  const Thin thin(scene);
  std::vector<int> finer;
  for (int level = 0; level < levels; ++level) {
    int by = std::min(level, most_finer);
    while ((lattice.tile_cells << by) > most_cells) --by;
    // A feature thinner than half a cell is left out at any spacing.
    for (; by > 0; --by) {
      const double thinnest = lattice.spacing(level - by) / 2;
      const double thinner = by == most_finer ? lattice.spacing(level) : 2 * lattice.spacing(level);
      if (thin.any_between(thinnest, thinner)) break;
    }
    finer.push_back(by);
  }
  const bool none = std::ranges::all_of(finer, [](int by) { return by == 0; });
  return none ? std::vector<int>{} : finer;
}

}  // namespace hoodoo::plan
