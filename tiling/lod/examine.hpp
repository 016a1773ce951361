#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "tiling/lod/buckets.hpp"
#include "tiling/lod/deviation.hpp"
#include "tiling/lod/faces.hpp"
#include "tiling/surface/surface.hpp"

namespace hoodoo::lod {

/// What a simplified surface was found to be.
struct Findings {
  double error = 0;          // largest distance within what is allowed [steps]
  std::vector<Vec3> faults;  // where it is wrong or too far off
  bool torn = false;         // wrong as a whole: another Euler characteristic
  bool good() const { return faults.empty() && !torn; }
};

/// Compares simplified surfaces with the one they came from. Vertices keep their numbers.
class Examiner {
 public:
  explicit Examiner(const surface::Surface& surface);

  /// Turns edges of folded triangles where that unfolds them. A triangle is folded when nothing of
  /// the input within `error` of its middle faces its way: the simplifier lets a triangle turn a
  /// little with every step. Returns the middles of those that stay folded.
  std::vector<Vec3> unfold(Faces& faces, double error) const;

  /// Topology: the same border edges with the same materials, the same fans, nothing degenerate or
  /// doubled, no new chord along a border plane. Then distances both ways, and between material
  /// borders. Ends early past `most_faults`.
  Findings examine(const Faces& faces, double error, std::size_t most_faults) const;

  /// Marks the triangles of the input within `reach` of `p`.
  void mark(const Vec3& p, double reach, std::vector<bool>& marked) const;
  double spacing() const { return spacing_; }  // typical edge [steps]

 private:
  class Survey;
  bool upright(const Triangle& triangle, double error, std::uint32_t& hint) const;
  bool unfold_some(Faces& faces, std::vector<std::uint32_t>& folded, double error) const;
  Findings compare_topology(const Faces& faces, const HalfEdges& edges) const;

  const surface::Surface& surface_;
  std::vector<Vec3> points_;
  double spacing_;  // typical edge [steps]
  HalfEdges edges_;
  Topology topology_;
  std::vector<Triangle> borders_;  // between materials, as segments (a, b, b)
  Buckets buckets_;
};

}  // namespace hoodoo::lod
