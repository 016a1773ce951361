#pragma once
#include <memory>
#include <span>
#include <vector>

#include "engine/tree/field.hpp"
#include "tests/bench/bare.hpp"
#include "tests/bench/scene.hpp"

namespace hoodoo::bench {

/// The balls of a scene as one node of a construction tree.
tree::Node list_of(const std::vector<Ball>& balls, const Rough& rough);
/// The same as a blend of one node per ball.
tree::Node blend_of(const std::vector<Ball>& balls);

/// A height field with `balls` blended into it.
tree::Ground ground_of(tree::Node balls);

/// A scene through engine/tree, block after block.
class Engine {
 public:
  Engine(const Scene& scene, tree::Node balls);

  /// Keeps what reaches the scene's part, as tiling/slice does for a tile.
  void prune();
  std::unique_ptr<const tree::Field> field(const BlockCorner& b) const;
  /// F of every point of every block, as tiling/volume samples them: one field per block, the
  /// elevations of a column of blocks looked up once. The last block's stay in `out`, z fastest.
  void values(std::span<const BlockCorner> blocks, std::span<float> out) const;
  /// The same point by point in batches, for lone points.
  tree::Points points() const { return {x_, y_, z_}; }

 private:
  const Scene& scene_;
  tree::Ground ground_;
  std::vector<float> axis_, x_, y_, z_;
};

}  // namespace hoodoo::bench
