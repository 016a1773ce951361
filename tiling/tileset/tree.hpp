#pragma once
#include <map>
#include <vector>

#include "tiling/tileset/tileset.hpp"

namespace hoodoo::tileset {

/// The tiles of an index as a forest.
struct Tree {
  struct Node {
    const Record* record = nullptr;   // null: not finished
    std::vector<plan::Key> children;  // with something in them, and none missing beside them
    Box box;                          // of the content and all below [m]
    bool has_content() const { return record != nullptr && !record->empty; }
  };
  std::map<plan::Key, Node> nodes;  // finest level first; those with nothing below are left out
  std::vector<plan::Key> roots;
};

/// Replacement shows a tile's children instead of the tile, so children are taken in only where
/// every planned child is finished (an empty one has nothing to show), or their parent is not
/// there. `bake` must outlive the result.
Tree make_tree(const Bake& bake);

}  // namespace hoodoo::tileset
