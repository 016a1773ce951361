#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tiling/lod/buckets.hpp"
#include "tiling/lod/faces.hpp"
#include "tiling/surface/surface.hpp"

namespace hoodoo::lod {

/// Bucket sides in typical edges: about ten triangles of the input meet a bucket.
inline constexpr double bucket_edges = 1.5;

/// Edges between triangles of different materials, as segments (a, b, b).
std::vector<Triangle> material_borders(const HalfEdges& edges,
                                       std::span<const std::uint16_t> materials);

/// The surface before simplification, made ready to be compared with. Simplified surfaces keep its
/// numbers of vertices.
struct Original {
  explicit Original(const surface::Surface& surface);

  /// Something of the surface within `error` of the triangle's middle faces its way; `hint` as in
  /// `Buckets::beyond`.
  bool upright(const Triangle& triangle, double error, std::uint32_t& hint) const;

  const surface::Surface& surface;
  std::vector<Vec3> points;
  double spacing;  // typical edge [steps]
  HalfEdges edges;
  Topology topology;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> chords;
  std::vector<Triangle> borders;  // between materials, as segments (a, b, b)
  Buckets buckets;
};

}  // namespace hoodoo::lod
