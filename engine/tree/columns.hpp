#pragma once
#include <array>
#include <memory>
#include <vector>

#include "engine/tree/points.hpp"

namespace hoodoo::tree {

/// What height bodies have over 16 x 16 columns of points: kept between fields that stand above
/// each other, it saves looking the elevations up again. For grids of at most 16 x 16 columns with
/// the same x and y and fields of one ground, with the same windows and the same origin in x and y.
struct Columns {
  static constexpr std::size_t count = Cube::side * Cube::side;
  struct OfBody {
    std::array<double, count> h;                 // elevation and offset [m], at 16 i + j
    alignas(64) std::array<float, count> scale;  // of h - z
    alignas(64) std::array<float, count> edge;   // no point of the column has a larger F
  };
  std::vector<std::unique_ptr<OfBody>> bodies;  // as in the ground; null: not looked up yet

  void clear() { bodies.clear(); }
};

}  // namespace hoodoo::tree
