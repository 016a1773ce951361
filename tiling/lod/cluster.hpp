#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "tiling/lod/half_edges.hpp"
#include "tiling/surface/surface.hpp"

namespace hoodoo::lod {

struct Clustered {
  surface::Surface surface;
  std::vector<std::uint32_t> kept;  // per vertex: its number in the input, ascending
  double error = 0;  // largest distance of a vertex of the input that is gone [steps]
};

/// Merges the vertices of the input, block by block, blocks being cubes of side `block` steps.
///
/// Vertices of a block are merged into one of them where all triangles around them face about one
/// way, those that come of it do, too, and each vertex that goes lies within `error` steps of the
/// triangles left around it. Vertices on borders and between materials stay. Nothing where that
/// would remove little.
///
/// It is much quicker than collapsing edges one by one in the order of their errors, and leaves
/// that less to do.
/// Source: Rossignac, Borrel 1993, Multi-resolution 3D approximations for rendering complex scenes,
/// section 3 (clusters in a grid of cells); the conditions are ours.
std::optional<Clustered> cluster(const surface::Surface& surface, int block, double error);

/// As many handles and pieces as before, open at borders only, and sound everywhere. Clusters that
/// face one way hardly ever make it otherwise, but nothing in their conditions excludes it.
/// `topology` is that of `after`; `before` must be sound.
bool same_topology(const surface::Surface& before, const Clustered& after,
                   const Topology& topology);

}  // namespace hoodoo::lod
