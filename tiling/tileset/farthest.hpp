#pragma once
#include "tiling/tileset/patch.hpp"

namespace hoodoo::tileset {

/// The largest distance of any point of `from` to the nearest of `to`, or up to `more` above it:
/// never less; or `least`, where it is less than that. `side` [m] is a good size of buckets for the
/// triangles of `to`. Both have triangles.
///
/// A piece of a triangle is within what is known when its middle is, by its own radius less: a
/// distance changes no faster than its point moves. Else it is as near as its corners are to the
/// triangle nearest to its middle: the distance from one triangle is convex. Else it is halved.
double farthest(const Patch& from, const Patch& to, double side, double more, double least = 0);

}  // namespace hoodoo::tileset
