#pragma once
#include <filesystem>
#include <vector>

#include "tiling/tileset/tileset.hpp"

namespace hoodoo::tileset {

/// The tiles of an index as a forest, of which only flags in the tiles are held in memory; boxes
/// stand in a file that is gone with the tree.
///
/// Replacement shows a tile's children instead of the tile, so children are taken in only where
/// every planned child is finished (an empty one has nothing to show), or their parent is not
/// there.
class Tree {
 public:
  /// Reads every record once. `index` outlives this, and its tiles stay where they are.
  /// Errors: io, and what reading a record throws.
  Tree(Index& index, const std::filesystem::path& folder);
  ~Tree();
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;

  /// The tiles shown below one: with something in them, and none missing beside them.
  std::vector<plan::Tile*> children(const plan::Tile& tile) const;
  /// Of the content and all below [m].
  Box box(const plan::Tile& tile) const;
  /// Those of the coarsest level.
  std::vector<const plan::Tile*> roots() const;

 private:
  void note(plan::Tile& tile);
  void put(const plan::Tile& tile, const Box& box) const;

  Index& index_;
  std::filesystem::path folder_;
  int boxes_ = -1;  // one Box for each tile
};

}  // namespace hoodoo::tileset
