#pragma once
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "engine/base/vector.hpp"
#include "tiling/export/selection.hpp"

namespace hoodoo::exporting {

/// A point in steps of its level, from the scene origin.
using Position = std::array<std::int64_t, 3>;

/// What one tile adds to a mesh.
struct Piece {
  std::vector<Position> points;  // of new vertices, and by them:
  std::vector<Vec3f> normals;
  std::vector<std::array<std::uint8_t, 4>> colors;  // linear, as in surface::Mesh
  std::vector<std::uint16_t> materials;

  std::vector<std::array<std::uint64_t, 3>> triangles;  // by number among all vertices
  std::vector<std::uint16_t> faces;                     // material of each
};

/// Puts tiles of one level together: a vertex per position. Only positions in borders that another
/// tile may still share are held.
class Weld {
 public:
  /// `split`: a vertex per position and material.
  Weld(const plan::Lattice& lattice, int level, bool split)
      : side_(lattice.side(level)), split_(split) {}

  /// Tiles come by y, then by x. Vertices are numbered as triangles come to name them.
  Piece add(const plan::Key& key, const glb::Decoded& tile);
  std::uint64_t vertices() const { return vertices_; }

 private:
  struct Name {
    Position position;
    std::uint16_t material;  // 0 where vertices are not split
    friend bool operator==(const Name&, const Name&) = default;
  };
  struct Hash {
    std::size_t operator()(const Name& name) const;
  };
  using Numbers = std::unordered_map<Name, std::uint64_t, Hash>;

  const std::int64_t side_;  // of a tile [steps]
  const bool split_;
  std::uint64_t vertices_ = 0;
  std::int64_t row_ = INT64_MIN;
  Numbers border_;
};

/// Welds all tiles of `selection` into `sink.add(piece)`, one after another.
template <class Sink>
void weld(const Selection& selection, bool split, Sink& sink) {
  Weld weld(selection.bake().lattice, selection.level(), split);
  for (const auto* record : selection.tiles()) {
    sink.add(weld.add(record->key, selection.read(*record)));
  }
}

}  // namespace hoodoo::exporting
