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

/// The edge between the triangles (from, to, x) and (to, from, y) turned: one between x and y.
struct Turn {
  std::uint32_t from, to, x, y;
  Triangle first() const { return {from, y, x}; }
  Triangle second() const { return {y, to, x}; }
};

/// Removes pairs of triangles that face each other on the same three vertices: where two vertices
/// with three neighbours in common are merged, the simplifier leaves such a fin standing on an
/// edge.
void drop_fins(Faces& faces, std::size_t vertices);

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
