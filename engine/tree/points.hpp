#pragma once
#include <cstddef>
#include <span>

namespace hoodoo::tree {

/// n sample points [m], relative to the origin of the block they belong to. Spans of length n.
/// Runs of equal (x, y) are evaluated faster: order grids with z fastest.
struct Points {
  std::span<const float> x, y, z;
  std::size_t size() const { return x.size(); }
};

/// n gradients [1/m]. Spans of length n.
struct Gradients {
  std::span<float> x, y, z;
};

}  // namespace hoodoo::tree
