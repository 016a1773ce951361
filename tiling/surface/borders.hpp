#pragma once
#include <cstdint>
#include <unordered_map>

#include "tiling/surface/surface.hpp"
#include "tiling/surface/tables.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::surface {

/// A lattice face across `axis`, by its low corner.
struct Face {
  std::size_t axis;
  volume::Index low;
};

/// Vertices of the two-dimensional dual contour in which the surface ends, appended to the points
/// of `out` when first asked for. Their numbers count from `first` on.
class Borders {
 public:
  Borders(const volume::Volume& volume, int units, std::size_t first, Surface& out)
      : volume_(volume), units_(units), first_(static_cast<std::uint32_t>(first)), out_(out) {}

  /// The vertex of the segment of `face` that holds its edge `k`. `marks` are Plane bits that the
  /// position alone does not tell.
  std::uint32_t face_vertex(const Face& face, int k, std::uint8_t marks);
  /// A vertex of its own at the crossing of a lattice edge, one step inside the edge.
  std::uint32_t crossing_vertex(int axis, const volume::Index& low, std::uint8_t marks);

 private:
  std::uint8_t planes_at(const volume::Index& p, std::size_t axis) const;
  std::uint64_t key(const Face& face) const;
  FaceCase case_of(const Face& face) const;
  void add_segments(const Face& face, const FaceCase& pairs, std::uint8_t planes);
  void append(const volume::Index& low, const std::array<std::int32_t, 3>& steps,
              std::uint8_t planes);
  std::uint32_t next() const { return first_ + static_cast<std::uint32_t>(out_.points.size()); }

  const volume::Volume& volume_;
  const int units_;
  const std::uint32_t first_;
  Surface& out_;
  std::unordered_map<std::uint64_t, std::uint32_t> first_vertex_;  // by face
};

}  // namespace hoodoo::surface
