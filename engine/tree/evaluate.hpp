#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/tree/node.hpp"
#include "engine/tree/points.hpp"

namespace hoodoo::tree {

/// At most so many points go through a kernel at once; kernels keep their arrays on the stack.
inline constexpr std::size_t batch_size = 256;

/// The rows of a cube, at 16 i + j: not 0 where a primitive was asked.
using AskedRows = std::array<std::uint8_t, Cube::side * Cube::side>;

/// A construction tree compiled for one block: its values at points relative to the block's origin.
/// Immutable; any number of threads. A 0 may be -0: which of them depends on what was pruned.
class Kernel {
 public:
  virtual ~Kernel() = default;
  /// At most batch_size points.
  virtual void values(const Points& at, std::span<float> out) const = 0;
  /// The same bits in `out`, and the gradient.
  virtual void gradients(const Points& at, std::span<float> out, const Gradients& g) const = 0;
  /// The bits that `values` gives at the points of a cube. Marks the rows at which a primitive was
  /// asked; at the others the value is 0.
  virtual void cube(const Cube& at, CubeValues out, AskedRows& asked) const;
  /// Types of the nodes that are left, one line each, indented by depth.
  virtual void explain(int depth, std::vector<std::string>& lines) const = 0;
};

/// A compiled tree. Without a kernel it is exactly 0 in the block.
struct Compiled {
  std::unique_ptr<const Kernel> kernel;
  Interval bounds{0, 0};  // of the value at every point of the block's box, rounded outward
};

/// Compiles `tree` for a block: leaves whose support misses it are dropped, as are terms of min and
/// max that another beats throughout. What is left gives the same bits as the whole tree would at
/// the points of the box, whose corners are finite. Points are fixed.
Compiled compile(const Node& tree, const Block& block);

/// How far single precision may have moved a thing of reach `box` seen from the block [m].
double rounding(const Box& box, const Block& block);

}  // namespace hoodoo::tree
