#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "engine/dem/window.hpp"

namespace hoodoo::bench {

/// e (1 - (r / reach)^2)^3 about a centre [m].
struct Ball {
  float x, y, z, reach, energy;
};

/// Low corner of a block of 16^3 points, 1 m apart.
using BlockCorner = std::array<int, 3>;

inline constexpr int side = 16;
inline constexpr int points_per_block = side * side * side;
inline constexpr float ground_falloff = 15;  // R [m] of the height field

/// Balls strewn along fractal ground, and the blocks of 16^3 points around a part of its surface.
struct Scene {
  int low = 0, wide = 0;  // of the square part in x and y [m]
  std::vector<Ball> balls;
  std::vector<float> heights;         // of its columns, x fastest
  std::vector<BlockCorner> blocks;    // columns of blocks one after the other, upward
  dem::Window window;                 // the same heights
  int margin = 0;                     // samples of the window around the part
  std::vector<float> samples;         // of the window, x fastest
  float height(int x, int y) const {  // of a column inside the part
    return heights[static_cast<std::size_t>((y - low) * wide + (x - low))];
  }
  double points() const { return static_cast<double>(blocks.size()) * points_per_block; }
};

/// Fractal noise in [-1, 1], its longest wave 500.
float fractal(float x, float y);

/// `count` balls of reach 4 to 12 m over [from, to]^2, each carving; the part is `wide` m wide
/// from `low` on. Blocks lie within `band` m of the ground.
Scene strew(int count, float from, float to, int low, int wide, float band);

/// Landscapes of the size of two in Table 1 of Paris et al. 2019, one column per metre: a coast of
/// 2000 x 2000 m with 33 m of relief and 50,693 balls along its cliff, and a canyon of 1000 x 1000
/// m with 546 m and 137,043 balls over two fifths of it. Both have no blocks.
Scene sea();
Scene canyon();

}  // namespace hoodoo::bench
