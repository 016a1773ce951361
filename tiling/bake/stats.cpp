#include "tiling/bake/stats.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>
#include <variant>
#include <vector>

#include "engine/dem/keys.hpp"
#include "engine/tree/field.hpp"
#include "engine/tree/reach.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/surface/mesh.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::bake {
namespace {

constexpr std::size_t most_tiles_asked = 16;  // in full columns, of all primitives
constexpr int columns_per_tile = 4;

double processor_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::uint64_t multiplied(std::uint64_t of_part, double by) {
  return static_cast<std::uint64_t>(std::llround(static_cast<double>(of_part) * by));
}

class Measuring {
 public:
  Measuring(const scene::Scene& scene, const plan::Lattice& lattice, Statistics& all)
      : scene_(scene), lattice_(lattice), all_(all) {}

  void whole() {
    for (const auto& step : scene_.ground.steps) {
      all_.nodes += tree::count(step.tree);
      all_.memory += tree::memory(step.tree);
    }
    if (scene_.ground.geology) {
      all_.nodes += tree::count(*scene_.ground.geology);
      all_.memory += tree::memory(*scene_.ground.geology);
    }
    Vec3 size = scene_.extent.max - scene_.extent.min;
    const Interval z = relief();
    size.z = z.high - z.low;
    for (std::size_t a = 0; a < 3; ++a) {
      const double cells = std::max(1.0, std::ceil(size[static_cast<int>(a)] / lattice_.spacing0));
      all_.grid[a] = static_cast<std::int64_t>(cells);
    }
    all_.all_calls = 1;
    for (const auto cells : all_.grid) all_.all_calls *= static_cast<std::uint64_t>(cells + 1);
  }

  void tile(const plan::Key& key, bool asks) {
    const double from = processor_seconds();
    const auto slice = slice::cut(scene_, lattice_, key);
    slice::Land land(slice, scene_.pyramids);
    const auto volume = volume::sample(land);
    const auto surface = surface::extract(volume, land);
    all_.seconds += processor_seconds() - from;
    all_.calls += volume.evaluations() + land.evaluations();
    find_bounds(land);
    if (asks) ask_columns(slice);
  }

  /// From the measured tiles to all.
  void multiply() {
    const double by = static_cast<double>(all_.tiles) /
                      static_cast<double>(std::max<std::uint64_t>(1, all_.tiles_measured));
    all_.seconds *= by;
    all_.calls = multiplied(all_.calls, by);
    all_.bounded_calls = multiplied(all_.bounded_calls, by);
    all_.covered = columns_ > 0 ? static_cast<double>(covered_) / static_cast<double>(columns_) : 0;
    const double each = asked_ > 0 ? asking_ / static_cast<double>(asked_) : 0;
    all_.all_seconds = each * static_cast<double>(all_.all_calls);
  }

 private:
  /// The z [m] between which the elevations lie and the trees can act. The world's extent is wider:
  /// it holds whatever an interpolation of any elevations between those could reach.
  Interval relief() const {
    Interval z{Box::infinity, -Box::infinity};
    const auto join = [&z](double low, double high) {
      if (std::isfinite(low)) z.low = std::min(z.low, low);
      if (std::isfinite(high)) z.high = std::max(z.high, high);
    };
    for (std::size_t i = 0; i < scene_.pyramids.size(); ++i) {
      const auto wide = scene_.pyramids[i]->bounds(0, scene_.extent);
      if (!wide) continue;
      const double middle = (wide->low + wide->high) / 2 + scene_.ground.bodies[i].offset;
      const double half = (wide->high - wide->low) / 2 / dem::keys_overshoot;
      join(middle - half, middle + half);
    }
    if (scene_.floor) join(*scene_.floor, *scene_.floor);
    for (const auto& step : scene_.ground.steps) {
      const auto reach = tree::reach_over(step, scene_.extent);
      if (!reach.empty()) join(reach.z.low, reach.z.high);
    }
    return z;
  }

  struct Bounds {
    double low = Box::infinity, high = -Box::infinity;  // whole cells
    bool empty() const { return low > high; }
    void join(const Bounds& other) {
      low = std::min(low, other.low);
      high = std::max(high, other.high);
    }
  };

  /// Of the lattice points of a column, and whether a tree can act there.
  Bounds bounds_of(const slice::Land& land, double x, double y, bool& covered) const {
    const double s = lattice_.spacing0;
    Box column{{x, y, scene_.extent.min.z}, {x, y, scene_.extent.max.z}};
    const auto join = [s](Bounds& bounds, const Interval& z) {
      if (z.low <= z.high) bounds.join({std::floor(z.low / s), std::floor(z.high / s)});
    };
    Bounds bounds;
    join(bounds, land.heights_at(x, y));
    covered = false;
    for (const auto& step : land.slice().ground.steps) {
      const auto reach = tree::reach_over(step, column);
      covered = covered || !reach.empty();
      join(bounds, reach.z);
    }
    return bounds;
  }

  /// Bounds of a tile's columns and one around them, joined with those beside them.
  void find_bounds(const slice::Land& land) {
    const auto& slice = land.slice();
    const int n = lattice_.tile_cells, wide = n + 2;
    std::vector<Bounds> bounds(static_cast<std::size_t>(wide * wide));
    for (int j = 0; j < wide; ++j) {
      for (int i = 0; i < wide; ++i) {
        const auto x = slice.key.x * n + i - 1, y = slice.key.y * n + j - 1;
        bool covered = false;
        bounds[static_cast<std::size_t>(j * wide + i)] =
            bounds_of(land, static_cast<double>(x) * lattice_.spacing0,
                      static_cast<double>(y) * lattice_.spacing0, covered);
        const bool inside = i > 0 && j > 0 && i <= n && j <= n && land.in_world(x, y);
        columns_ += inside ? 1 : 0;
        covered_ += inside && covered ? 1 : 0;
      }
    }
    for (int j = 1; j <= n; ++j) {
      for (int i = 1; i <= n; ++i) {
        if (!land.in_world(slice.key.x * n + i - 1, slice.key.y * n + j - 1)) continue;
        Bounds joined;
        for (int k = 0; k < 9; ++k) {
          joined.join(bounds[static_cast<std::size_t>((j + k / 3 - 1) * wide + i + k % 3 - 1)]);
        }
        if (joined.empty()) continue;
        all_.bounded_calls += static_cast<std::uint64_t>(joined.high - joined.low) + 2;
      }
    }
  }

  /// Asks a field that nothing was left out of at every point of a few columns.
  void ask_columns(const slice::Slice& slice) {
    const Box near = slice::reach(lattice_, slice.key);
    std::vector<dem::Window> windows;
    for (std::size_t i = 0; i < scene_.pyramids.size(); ++i) {
      windows.push_back(scene_.pyramids[i]->window(slice.elevations[i].level, near));
    }
    const Vec3 origin{near.min.x, near.min.y, scene_.extent.min.z};
    const auto field = tree::compile(scene_.ground, windows, origin, scene_.extent);
    const double side = lattice_.tile_cells * lattice_.spacing0;
    const auto n = static_cast<std::size_t>(all_.grid[2] + 1);
    std::vector<float> x(n), y(n), z(n), value(n);
    for (std::size_t k = 0; k < n; ++k)
      z[k] = static_cast<float>(static_cast<double>(k) * lattice_.spacing0);
    for (int c = 0; c < columns_per_tile; ++c) {
      const Box area = lattice_.area(slice.key);
      std::fill(x.begin(), x.end(),
                static_cast<float>(area.min.x - origin.x + (0.2 + 0.2 * c) * side));
      std::fill(y.begin(), y.end(),
                static_cast<float>(area.min.y - origin.y + (0.8 - 0.2 * c) * side));
      const double from = processor_seconds();
      field->values({x, y, z}, value);
      asking_ += processor_seconds() - from;
      asked_ += n;
      ++all_.columns_asked;
    }
  }

  const scene::Scene& scene_;
  const plan::Lattice& lattice_;
  Statistics& all_;
  std::uint64_t columns_ = 0, covered_ = 0, asked_ = 0;
  double asking_ = 0;
};

}  // namespace

Statistics measure_scene(const scene::Scene& scene, const plan::Lattice& lattice,
                         std::span<const plan::Tile> planned) {
  // By key: the finest come first.
  const auto tiles = planned.first(static_cast<std::size_t>(
      std::ranges::find_if(planned, [](const auto& t) { return t.level > 0; }) - planned.begin()));
  Statistics all;
  all.tiles = tiles.size();
  all.tiles_measured = std::min(tiles.size(), Statistics::most_tiles);
  Measuring measuring(scene, lattice, all);
  measuring.whole();
  const auto every = std::max<std::size_t>(1, all.tiles_measured / most_tiles_asked);
  for (std::size_t i = 0; i < all.tiles_measured; ++i) {
    measuring.tile(tiles[i * tiles.size() / all.tiles_measured].key(), i % every == 0);
  }
  measuring.multiply();
  return all;
}

}  // namespace hoodoo::bake
