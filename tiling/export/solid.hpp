#pragma once
#include "tiling/tileset/patch.hpp"

namespace hoodoo::exporting {

/// Closes the solid under a welded surface whose edges with one face lie in upright planes of
/// constant x or y, as those at tile borders and at the world's edge do: by the parts of those
/// planes that are solid, and a floor at the height `floor` [m] under all of it. Corners of the new
/// triangles need not meet those of old ones, but there is no gap. Returns whether anything was
/// open.
/// Errors: bad_input, when an open edge lies in no such plane.
bool close(tileset::Patch& patch, double floor);

}  // namespace hoodoo::exporting
