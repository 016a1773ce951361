#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "tiling/lod/half_edges.hpp"

namespace hoodoo::lod {

/// Triangles with the material of each.
struct Faces {
  std::vector<Triangle> triangles;
  std::vector<std::uint16_t> materials;
};

/// Edges that run from border to border in one border plane without being border edges.
/// `planes` are Plane bits per vertex.
std::vector<std::pair<std::uint32_t, std::uint32_t>> chords(
    const HalfEdges& edges, const std::vector<std::uint8_t>& planes);

/// Turns chords away from the border where that can be done.
///
/// Where an inner vertex is merged into a border vertex, the border can be left with a chord, and
/// a triangle flat in the plane behind it. The neighbour across the plane may get the same one,
/// and the two would then lie on each other.
void turn_chords(Faces& faces, const std::vector<std::uint8_t>& planes);

}  // namespace hoodoo::lod
