#pragma once
#include <cstdint>

#include "tiling/surface/surface.hpp"

/// tiling/lod: surface -> simplified surface.
namespace hoodoo::lod {

struct Simplified {
  surface::Surface surface;
  double error = 0;  // largest distance found between the two, both ways, in steps
};

/// Removes triangles from the interior, keeping every border edge and vertex, every material
/// border within the error, and the surface manifold. Vertices of nearby cells of side `cell` are
/// merged first where the ground is level, within a small share of the error; then edges are
/// collapsed. The distance between input and result is measured, not estimated, and at most
/// `error` steps: of the first from each vertex that goes, of the second both ways (dense samples
/// of each against the other), and added up. Where the result is too far off it is mended place by
/// place; what cannot be mended is tried again at less, at last left as it is. Points are a subset
/// of the input's. Same input, same output.
/// Source: Rossignac, Borrel 1993 (clusters); meshoptimizer (Garland, Heckbert 1997); the
/// measurement is ours.
Simplified simplify(const surface::Surface& surface, double error, int cell);

/// Two faces on every edge that is not on a border, none doubled, none degenerate; borders as in
/// `original` when given.
bool is_manifold(const surface::Surface& surface, const surface::Surface* original = nullptr);

/// Edges with one face between two vertices marked `world_edge`: what stays open when a level's
/// tiles are put together.
std::uint64_t world_edges(const surface::Surface& surface);

}  // namespace hoodoo::lod
