#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <ostream>
#include <vector>

#include "tests/tiling/surface/lattice.hpp"

namespace hoodoo::surface::testing {

/// Triangles over numbered points: one tile's as they are, or those of several tiles with points
/// of equal position made one.
struct Net {
  std::vector<std::array<std::int64_t, 3>> points;  // steps from the lattice's origin
  std::vector<std::uint8_t> planes;                 // of any tile that has the point
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint16_t> materials;
  std::vector<int> tiles;  // the tile of each triangle
};

Net net_of(const Surface& surface, const Index& low, int units);
Net weld(const std::vector<Net>& tiles);

/// What can be wrong with a net; all zero is right.
struct Faults {
  long degenerate = 0;      // a corner twice, or no area
  long doubled = 0;         // two triangles on the same three points
  long crowded_edges = 0;   // an edge with two triangles on the same side, or three
  long open_edges = 0;      // an edge with one triangle where `may_end` does not hold for both ends
  long broken_fans = 0;     // a point whose triangles are not one fan (or several, at the border)
  long unequal_labels = 0;  // materials differ across an edge between tiles
  friend bool operator==(const Faults&, const Faults&) = default;
};
std::ostream& operator<<(std::ostream& out, const Faults& faults);

/// `may_end`: the surface may end at this point. `may_pinch`: several fans may meet there.
using Where = std::function<bool(std::uint32_t point)>;
Faults faults_of(const Net& net, const Where& may_end, const Where& may_pinch);

/// Points - edges + triangles.
long euler_characteristic(const Net& net);

}  // namespace hoodoo::surface::testing
