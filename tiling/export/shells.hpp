#pragma once
#include "tiling/tileset/patch.hpp"

namespace hoodoo::exporting {

/// A surface by what its connected parts enclose.
struct Shells {
  tileset::Patch solids;    // parts with an open edge, and closed ones around rock
  tileset::Patch cavities;  // closed ones around air, turned inside out
  tileset::Patch inner;     // those of `solids` that may stand in a cavity, once more
};

/// Sorts the parts of a welded surface. A part stands in a cavity when that one's box holds it and
/// encloses more; cavities in such a part are left to `cavities`.
Shells sort_shells(const tileset::Patch& surface);

}  // namespace hoodoo::exporting
