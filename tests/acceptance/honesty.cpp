// Is a tile's stated error the truth?
//
//   honesty DIR
//
// For every tile of a finished bake above the leaves: the largest distance between its surface and
// that of the leaves below it, both ways, by samples a quarter of its spacing apart; against its
// geometricError. Prints one line of JSON; ends with 1 when a tile is farther off than it says, or
// the median of stated over found is above 3.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <vector>

#include "tiling/glb/earth.hpp"
#include "tiling/lod/buckets.hpp"
#include "tiling/lod/deviation.hpp"
#include "tiling/tileset/content.hpp"
#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/patch.hpp"

using namespace hoodoo;

namespace {

constexpr double most_median = 3;

/// Largest distance of samples of `from` to `to`.
double sampled(const tileset::Patch& from, const tileset::Patch& to, double spacing) {
  const lod::Buckets buckets(to.points, to.triangles, 4 * spacing);
  lod::Farthest farthest(Box::infinity, 1e-6 * spacing);
  for (const auto& [ia, ib, ic] : from.triangles) {
    const Vec3 &a = from.points[ia], &b = from.points[ib], &c = from.points[ic];
    for (const auto& p : {a, b, c}) farthest.look(p, buckets);
    lod::for_each_sample(a, b, c, spacing, [&](const Vec3& p) { farthest.look(p, buckets); });
  }
  return farthest.distance();
}

class Bake {
 public:
  explicit Bake(const std::filesystem::path& folder)
      : folder_(folder), manifest_(tileset::read_manifest(folder)) {
    for (const auto& record : manifest_.records) {
      if (!record.empty) records_[record.key] = &record;
    }
  }

  /// Stated error and distance found of every tile above the leaves that has some below it.
  std::vector<std::pair<double, double>> measure() const {
    std::vector<std::pair<double, double>> all;
    for (const auto& [key, record] : records_) {
      if (key.level == 0) continue;
      tileset::Patch tile, leaves;
      add(tile, *record, record->box.min);
      add_leaves(leaves, key, record->box.min);
      if (leaves.triangles.empty()) continue;
      const double spacing = manifest_.lattice.spacing(key.level) / 4;
      const double found = std::max(sampled(tile, leaves, spacing), sampled(leaves, tile, spacing));
      all.emplace_back(manifest_.errors.at(key), found);
    }
    return all;
  }

 private:
  void add(tileset::Patch& patch, const tileset::Record& record, const Vec3& corner) const {
    const double step = manifest_.lattice.step(record.key.level);
    const bool earth = !manifest_.frame.vertical.empty();
    tileset::add(patch, tileset::read_tile(folder_, record, earth ? step / glb::finer : step),
                 corner);
  }
  void add_leaves(tileset::Patch& patch, const plan::Key& key, const Vec3& corner) const {
    if (key.level == 0) {
      const auto leaf = records_.find(key);
      if (leaf != records_.end()) add(patch, *leaf->second, corner);
      return;
    }
    for (const int x : {0, 1}) {
      for (const int y : {0, 1}) {
        add_leaves(patch, {key.level - 1, 2 * key.x + x, 2 * key.y + y}, corner);
      }
    }
  }

  std::filesystem::path folder_;
  tileset::Manifest manifest_;
  std::map<plan::Key, const tileset::Record*> records_;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "honesty DIR\n";
    return 2;
  }
  const auto measured = Bake(argv[1]).measure();
  double worst = 0;
  std::vector<double> shares;  // stated over found
  for (const auto& [stated, found] : measured) {
    worst = std::max(worst, found / stated);
    if (found > 0) shares.push_back(stated / found);
  }
  std::ranges::sort(shares);
  const double median = shares.empty() ? 0 : shares[shares.size() / 2];
  const bool good = !shares.empty() && worst <= 1 && median <= most_median;
  fmt::print(
      "{{\"tiles\": {}, \"maxTrueOverStated\": {:.4f}, \"medianStatedOverTrue\": {:.3f}, "
      "\"good\": {}}}\n",
      measured.size(), worst, median, good);
  return good ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << "honesty: " << error.what() << "\n";
  return 2;
}
