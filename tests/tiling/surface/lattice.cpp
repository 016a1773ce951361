#include "tests/tiling/surface/lattice.hpp"

#include <algorithm>

namespace hoodoo::surface::testing {
namespace {

Vec3 to_point(const Index& p) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}
Vec3f to_float(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
double lerp(double a, double b, double t) { return a + (b - a) * t; }

template <class Visit>
void for_each_point(const Index& low, const Index& high, Visit visit) {
  for (std::int64_t k = low[2]; k < high[2]; ++k) {
    for (std::int64_t j = low[1]; j < high[1]; ++j) {
      for (std::int64_t i = low[0]; i < high[0]; ++i) visit(Index{i, j, k});
    }
  }
}

}  // namespace

Vec3 gradient(const Function& f, const Vec3& p) {
  constexpr double e = 1e-4;
  Vec3 g;
  for (int a = 0; a < 3; ++a) {
    Vec3 low = p, high = p;
    low[a] -= e;
    high[a] += e;
    g[a] = (f(high) - f(low)) / (2 * e);
  }
  return g;
}

double distance_to_surface(const Function& f, const Vec3& p) {
  Vec3 x = p;
  for (int i = 0; i < 12; ++i) {
    const Vec3 g = gradient(f, x);
    const double g2 = dot(g, g);
    if (g2 < 1e-12) break;
    Vec3 step = g * (f(x) / g2);
    const double l = length(step);
    if (l > 0.3) step = step * (0.3 / l);
    x = x - step;
    if (l < 1e-9) break;
  }
  return length(x - p);
}

Lattice lattice_of(Function f) {
  Lattice lattice;
  lattice.solid = [f](const Index& p) { return f(to_point(p)) > 0; };
  lattice.crossing = [f](int axis, const Index& low) {
    const Vec3 from = to_point(low);
    const auto at = [&](double t) {
      Vec3 p = from;
      p[axis] += t;
      return p;
    };
    const bool solid = f(from) > 0;
    double inside = 0, outside = 1;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (inside + outside);
      ((f(at(middle)) > 0) == solid ? inside : outside) = middle;
    }
    Vec3 fallback;
    fallback[axis] = solid ? 1 : -1;
    const double t = 0.5 * (inside + outside);
    return Crossing{static_cast<float>(t), to_float(normalized(-gradient(f, at(t)), fallback)), 0};
  };
  return lattice;
}

Lattice random_lattice(std::uint64_t seed, double roughness, int pattern, double holes) {
  Lattice lattice;
  const auto random = [seed](const Index& p, int what) {
    return unit_real(random_bits(seed, p[0], p[1], p[2], what));
  };
  const auto solid = [=](const Index& p) {
    const bool base = pattern == 1   ? ((p[0] + p[1] + p[2]) & 1) != 0
                      : pattern == 2 ? ((p[0] + p[1]) & 1) != 0
                                     : false;
    return base != (random(p, 0) < roughness);
  };
  lattice.solid = solid;
  lattice.crossing = [=](int axis, const Index& low) {
    const int what = 10 * (axis + 1);
    Crossing c;
    const double end = random(low, what);
    c.t = end < 0.1 ? 0.0F : end > 0.9 ? 1.0F : static_cast<float>(random(low, what + 1));
    Vec3 n;
    for (int a = 0; a < 3; ++a) n[a] = 2 * random(low, what + 2 + a) - 1;
    c.normal = to_float(normalized(n));
    Index solid_end = low;
    if (!solid(low)) ++solid_end[static_cast<std::size_t>(axis)];
    c.material = random(solid_end, 1) < 0.5 ? 1 : 2;
    return c;
  };
  lattice.in_world = [=](std::int64_t i, std::int64_t j) { return random({i, j, 0}, 2) >= holes; };
  return lattice;
}

volume::Volume fill(const Lattice& lattice, const Index& low, const Index& high, Store store) {
  volume::Volume volume(low, high);
  for (std::int64_t j = low[1] - 1; j <= high[1]; ++j) {
    for (std::int64_t i = low[0] - 1; i <= high[0]; ++i) {
      volume.set_in_world(i, j, lattice.in_world(i, j));
    }
  }
  for_each_point(volume.block_low(), volume.block_high(), [&](const Index& b) {
    Index from, to;
    for (std::size_t a = 0; a < 3; ++a) {
      from[a] = std::max(16 * b[a], low[a]);
      to[a] = std::min(16 * b[a] + 16, high[a] + 1);
    }
    const bool first = lattice.solid(from);
    bool mixed = false;
    for_each_point(from, to, [&](const Index& p) { mixed = mixed || lattice.solid(p) != first; });
    if (!mixed && store == Store::mixed_blocks) {
      volume.set_uniform(b, first);
    } else {
      for_each_point(from, to, [&](const Index& p) { volume.set_solid(p, lattice.solid(p)); });
    }
  });
  volume.mark();
  volume.for_each_crossing(
      [&](int axis, const Index& p) { volume.crossing(axis, p) = lattice.crossing(axis, p); });
  return volume;
}

double value_noise(const Vec3& p, std::uint64_t seed) {
  const Vec3 cell{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
  const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const auto at = [&](int i, int j, int k) {
    return 2 * unit_real(random_bits(seed, static_cast<std::int64_t>(cell.x) + i,
                                     static_cast<std::int64_t>(cell.y) + j,
                                     static_cast<std::int64_t>(cell.z) + k)) -
           1;
  };
  const double u = fade(p.x - cell.x), v = fade(p.y - cell.y), w = fade(p.z - cell.z);
  const auto row = [&](int j, int k) { return lerp(at(0, j, k), at(1, j, k), u); };
  return lerp(lerp(row(0, 0), row(1, 0), v), lerp(row(0, 1), row(1, 1), v), w);
}

std::vector<Box3> eight_tiles(const Index& low, std::int64_t side) {
  std::vector<Box3> tiles;
  for (int t = 0; t < 8; ++t) {
    const Index from{low[0] + side * (t & 1), low[1] + side * (t >> 1 & 1),
                     low[2] + side * (t >> 2)};
    tiles.push_back({from, {from[0] + side, from[1] + side, from[2] + side}});
  }
  return tiles;
}

}  // namespace hoodoo::surface::testing
