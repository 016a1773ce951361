#include "tiling/compare/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "engine/base/error.hpp"
#include "tiling/compare/measure.hpp"
#include "tiling/compare/surfaces.hpp"
#include "tiling/compare/view.hpp"

namespace hoodoo::compare {
namespace {

namespace fs = std::filesystem;
using Change = Tile::Change;

/// Below this share, triangles of a rock come and go with the mesh.
constexpr double most_material = 0.01;

Box plan_intersection(const Box& a, const Box& b) {
  Box common = intersection(a, b);
  common.min.z = -Box::infinity;
  common.max.z = Box::infinity;
  return common;
}

/// Around the surface of the leaves.
Box leaf_bounds(const Surfaces& bake) {
  Box box;
  for (const auto& [key, record] : bake.tiles()) {
    if (key.level == 0) box.add(bake.bounds(key));
  }
  return box;
}

double leaf_side(const Surfaces& bake) {
  return bake.manifest().lattice.spacing0 * bake.manifest().lattice.tile_cells;
}

/// The two bakes and what they have been asked so far.
class Walk {
 public:
  Walk(const fs::path& first, const fs::path& second, const Settings& settings)
      : first_(first), second_(second) {
    result_.settings = settings;
    result_.first = first_.manifest().lattice;
    result_.second = second_.manifest().lattice;
    align(second);
  }

  Comparison run() {
    result_.by_region ? compare_regions() : compare_tiles();
    std::ranges::stable_sort(result_.tiles, worse);
    for (const auto& tile : result_.tiles) {
      if (result_.views.size() == result_.settings.pictures) break;
      if (tile.change == Change::changed) result_.views.push_back(view(tile));
    }
    result_.read = first_.read() + second_.read();
    return std::move(result_);
  }

 private:
  struct Pair {
    std::vector<plan::Key> first, second;
  };

  void align(const fs::path& second) {
    const auto &a = first_.manifest(), &b = second_.manifest();
    if (a.frame.crs != b.frame.crs || a.frame.unit != b.frame.unit) {
      const auto name = [](const std::string& crs) { return crs.empty() ? "a local frame" : crs; };
      throw Error(
          Fault::bad_input, second.string(),
          fmt::format("is in another frame: {}, not {}", name(b.frame.crs), name(a.frame.crs)));
    }
    const Vec3 shift{b.frame.origin_x - a.frame.origin_x, b.frame.origin_y - a.frame.origin_y, 0};
    second_.shift(shift);
    result_.by_region = shift != Vec3{} || a.lattice.spacing0 != b.lattice.spacing0 ||
                        a.lattice.tile_cells != b.lattice.tile_cells;
    if (!result_.by_region) return;
    result_.regions_of_second = leaf_side(second_) < leaf_side(first_);
    ground_ = plan_intersection(leaf_bounds(first_), leaf_bounds(second_));
    if (!(ground_.min.x < ground_.max.x && ground_.min.y < ground_.max.y)) {
      throw Error(Fault::bad_input, second.string(), "has no ground in common with the first bake");
    }
  }

  /// The worst first: those of one bake alone, then by distance in spacings.
  static bool worse(const Tile& a, const Tile& b) {
    const auto rank = [](const Tile& t) {
      const bool alone = t.change != Change::changed;
      return std::tuple(!t.beyond, !alone, -t.largest / plan::Lattice::scale(t.key.level), t.key);
    };
    return rank(a) < rank(b);
  }

  void compare_tiles() {
    std::set<plan::Key> keys;
    for (const auto* bake : {&first_, &second_}) {
      for (const auto& [key, record] : bake->tiles()) keys.insert(key);
    }
    result_.compared = keys.size();
    for (const auto& key : keys) {
      const auto a = first_.tiles().find(key), b = second_.tiles().find(key);
      if (a == first_.tiles().end()) {
        result_.tiles.push_back({.key = key, .change = Change::added});
      } else if (b == second_.tiles().end()) {
        result_.tiles.push_back({.key = key, .change = Change::gone});
      } else if (a->second->content != b->second->content) {
        result_.tiles.push_back(*measured(key));
      }
    }
  }

  void compare_regions() {
    std::set<plan::Key> keys;
    const Surfaces& lattice = regions();
    for (const auto* bake : {&first_, &second_}) {
      for (const auto& [key, record] : bake->tiles()) {
        if (key.level != 0) continue;
        const Box area = plan_intersection(bake->area(key), ground_);
        for (const auto& region : lattice.lattice_over(area, 0)) keys.insert(region);
      }
    }
    for (const auto& key : keys) {
      const auto tile = measured(key);
      if (!tile) continue;
      ++result_.compared;
      if (tile->change != Change::changed || tile->largest > 0) result_.tiles.push_back(*tile);
    }
  }

  const Surfaces& regions() const { return result_.regions_of_second ? second_ : first_; }

  Question question(const plan::Key& key) const {
    Question question;
    question.spacing =
        std::min(result_.first.spacing(key.level), result_.second.spacing(key.level));
    question.tolerance = result_.settings.tolerance * plan::Lattice::scale(key.level);
    question.attributes = !result_.by_region;
    if (result_.by_region) question.ground = plan_intersection(regions().area(key), ground_);
    return question;
  }

  /// What lies under a tile or region, and around it.
  Pair under(const Box& area, int level) const {
    return {first_.over(area, level), second_.over(area, level)};
  }
  Pair around(const Box& area, int level) const {
    const double side = area.max.x - area.min.x;
    return under({area.min - Vec3{side, side, 0}, area.max + Vec3{side, side, 0}}, level);
  }

  /// Nothing where a region has no surface.
  std::optional<Tile> measured(const plan::Key& key) {
    const Box area = regions().area(key);
    const auto here = under(area, key.level), near = around(area, key.level);
    const auto asked = question(key);
    Around first(first_, near.first), second(second_, near.second);
    Findings found;
    for (const auto& k : here.first) found.add(measure(*first_.sheet(k), first_, second, asked));
    for (const auto& k : here.second) found.add(measure(*second_.sheet(k), second_, first, asked));
    if (!(found.area > 0)) return std::nullopt;
    Tile tile{.key = key};
    if (here.first.empty() || here.second.empty()) {
      tile.change = here.first.empty() ? Change::added : Change::gone;
      return tile;
    }
    tile.largest = std::sqrt(found.largest2);
    tile.mean = found.mean();
    tile.normal = found.normal_degrees();
    tile.material = found.changed_share();
    tile.beyond = tile.largest > asked.tolerance || tile.material > most_material ||
                  (!result_.by_region && result_.settings.tolerance == 0);
    return tile;
  }

  View view(const Tile& tile) {
    const Box area = regions().area(tile.key);
    const auto here = under(area, tile.key.level), near = around(area, tile.key.level);
    Around first(first_, near.first), second(second_, near.second);
    const auto before = shaded(first_, here.first, second, tile.key);
    const auto after = shaded(second_, here.second, first, tile.key);
    Box frame;
    for (const auto* surface : {&before, &after}) {
      for (std::size_t i = 0; i < surface->distances.size(); ++i) {
        if (surface->distances[i] >= 0) frame.add(surface->patch.points[i]);
      }
    }
    return {tile.key, draw(before, frame, tile.largest), draw(after, frame, tile.largest)};
  }

  Shaded shaded(Surfaces& bake, const std::vector<plan::Key>& keys, Around& other,
                const plan::Key& region) {
    Shaded all;
    for (const auto& key : keys) {
      const auto sheet = bake.sheet(key);
      std::vector<double> distances;
      measure(*sheet, bake, other, question(region), &distances);
      const auto first = static_cast<std::uint32_t>(all.patch.points.size());
      const auto& [points, triangles] = sheet->patch;
      all.patch.points.insert(all.patch.points.end(), points.begin(), points.end());
      for (const auto& [a, b, c] : triangles) {
        all.patch.triangles.push_back({first + a, first + b, first + c});
      }
      all.distances.insert(all.distances.end(), distances.begin(), distances.end());
    }
    return all;
  }

  Surfaces first_, second_;
  Box ground_ = Box::everywhere();  // that both cover, in plan
  Comparison result_;
};

}  // namespace

std::size_t Comparison::count(Change change) const {
  return static_cast<std::size_t>(std::ranges::count(tiles, change, &Tile::change));
}

std::size_t Comparison::beyond() const {
  return static_cast<std::size_t>(std::ranges::count(tiles, true, &Tile::beyond));
}

double Comparison::largest(int level) const {
  double most = 0;
  for (const auto& tile : tiles) {
    if (tile.key.level == level) most = std::max(most, tile.largest);
  }
  return most;
}

double Comparison::mean(int level) const {
  double sum = 0;
  int count = 0;
  for (const auto& tile : tiles) {
    if (tile.key.level != level || tile.change != Change::changed) continue;
    sum += tile.mean;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

Comparison compare(const fs::path& first, const fs::path& second, const Settings& settings) {
  return Walk(first, second, settings).run();
}

}  // namespace hoodoo::compare
