#pragma once
#include <cstdint>
#include <vector>

#include "engine/base/vector.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::generator {

/// A turn about an axis through the origin.
struct Turn {
  Vec3 axis;     // its direction
  double angle;  // [deg], counter-clockwise seen against the axis
};

/// Where a copy of a tree stands: scaled about its origin, turned by the last turn first, then by
/// the one before it, and so on, then moved.
struct Placement {
  Vec3 at;  // [m]
  std::vector<Turn> turns{};
  double scale = 1;

  /// Turns further, seen from the tree. Turns about one axis become one.
  void turn(const Turn& further);
  /// A place of the tree, in the scene.
  Vec3 of(const Vec3& p) const;
};

/// A copy of the tree. A tree of points and radii alone has its points moved; around any other
/// stand the nodes that move it, and its seeds are varied by `seed`, so that copies differ.
tree::Node placed(tree::Node tree, const Placement& placement, std::uint64_t seed);

/// The union of bodies. A block is compiled of those near it: with 1,000 hoodoos of 18 parts each,
/// compiling and pruning are a few hundredths of a bake, so that the union is flat.
tree::Node united(std::vector<tree::Node> bodies);

}  // namespace hoodoo::generator
