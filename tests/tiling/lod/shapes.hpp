#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "engine/base/random.hpp"
#include "tiling/surface/surface.hpp"

/// Surfaces on the lattice of steps for tests, 256 steps to a cell.
namespace hoodoo::shapes {

inline constexpr std::int32_t units = 256;

/// Value noise in [0, 1] of a lattice of `period` cells, smoothly interpolated.
inline double noise(double x, double y, double period, std::uint64_t seed) {
  const double u = x / period, v = y / period;
  const auto i = static_cast<std::int64_t>(std::floor(u)),
             j = static_cast<std::int64_t>(std::floor(v));
  const auto at = [&](std::int64_t a, std::int64_t b) {
    return unit_real(random_bits(seed, a, b));
  };
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double s = ease(u - static_cast<double>(i)), t = ease(v - static_cast<double>(j));
  const double low = at(i, j) + s * (at(i + 1, j) - at(i, j));
  const double high = at(i, j + 1) + s * (at(i + 1, j + 1) - at(i, j + 1));
  return low + t * (high - low);
}

/// Hills of `octaves` sizes from 64 cells down, in cells.
inline double hills(double x, double y, int octaves, double height) {
  double sum = 0, size = 64, share = height;
  for (int k = 0; k < octaves; ++k, size /= 2, share /= 2) {
    sum += share * noise(x, y, size, static_cast<std::uint64_t>(k));
  }
  return sum;
}

/// A height field over side x side cells starting at cell (x0, y0): a vertex per cell, moved off
/// its middle as dual contouring moves it, and a row of vertices on each border plane. Two
/// materials part at `boundary` cells of height when it is not negative.
struct Hills {
  int side = 64;
  int octaves = 4;
  double height = 20;  // of the largest hills [cells]
  double boundary = -1;
  std::int64_t x0 = 0, y0 = 0;  // [cells of the level]
  int level = 0;
  std::uint8_t world = 0;  // the Plane bits of borders that are the world's edge
};
inline surface::Surface height_field(const Hills& hills_of) {
  const int n = hills_of.side + 2;  // border, cells, border
  surface::Surface s;
  const auto coordinate = [&](int k, std::int64_t column, std::int64_t row, int axis) {
    if (k == 0) return 0;
    if (k == n - 1) return hills_of.side * units;
    const double jitter = unit_real(random_bits(99U, column, row, axis));
    return (k - 1) * units + 64 + static_cast<int>(jitter * 128);
  };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      // A border vertex is named by the cell row alone, so that neighbours have the same.
      const std::int64_t edge = 1'000'000;
      const auto column = i == 0 || i == n - 1 ? edge : hills_of.x0 + i;
      const auto row = j == 0 || j == n - 1 ? edge : hills_of.y0 + j;
      const int x = coordinate(i, column, row, 0), y = coordinate(j, column, row, 1);
      const double scale = 1 << hills_of.level;
      const double z = hills((static_cast<double>(hills_of.x0) + x / 256.0) * scale,
                             (static_cast<double>(hills_of.y0) + y / 256.0) * scale,
                             hills_of.octaves, hills_of.height) /
                       scale;
      s.points.push_back({x, y, static_cast<std::int32_t>(std::nearbyint(z * units))});
      s.planes.push_back(static_cast<std::uint8_t>(
          (i == 0 ? surface::west : 0) | (i == n - 1 ? surface::east : 0) |
          (j == 0 ? surface::south : 0) | (j == n - 1 ? surface::north : 0)));
      if ((s.planes.back() & hills_of.world) != 0) s.planes.back() |= surface::world_edge;
    }
  }
  const auto add = [&](int a, int b, int c) {
    const auto index = [](int i) { return static_cast<std::uint32_t>(i); };
    s.triangles.push_back({index(a), index(b), index(c)});
    const auto z = [&](int i) { return s.points[index(i)][2]; };
    const double middle = (z(a) + z(b) + z(c)) / (3.0 * units);
    s.materials.push_back(hills_of.boundary >= 0 && middle > hills_of.boundary ? 1 : 0);
  };
  for (int j = 0; j + 1 < n; ++j) {
    for (int i = 0; i + 1 < n; ++i) {
      const int a = j * n + i, b = a + 1, c = a + n, d = c + 1;
      add(a, b, d);
      add(a, d, c);
    }
  }
  return s;
}

/// A torus about z: `around` x `across` quads. Closed, Euler characteristic 0.
inline surface::Surface torus(int around, int across, double radius, double tube) {
  surface::Surface s;
  constexpr double turn = 2 * 3.14159265358979323846;
  const auto steps = [](double cells) {
    return static_cast<std::int32_t>(std::nearbyint(cells * units));
  };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double a = turn * i / around, b = turn * j / across, r = radius + tube * std::cos(b);
      s.points.push_back(
          {steps(r * std::cos(a)), steps(r * std::sin(a)), steps(tube * std::sin(b))});
      s.planes.push_back(0);
    }
  }
  const auto at = [&](int i, int j) {
    return static_cast<std::uint32_t>((i % around) * across + j % across);
  };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      s.materials.push_back(0);
      s.materials.push_back(0);
    }
  }
  return s;
}

}  // namespace hoodoo::shapes
