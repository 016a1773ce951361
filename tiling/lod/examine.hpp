#pragma once
#include <cstdint>
#include <vector>

#include "tiling/lod/faces.hpp"
#include "tiling/lod/original.hpp"

namespace hoodoo::lod {

/// Where a simplified surface is wrong or too far off.
struct Fault {
  enum class Kind : std::uint8_t {
    topology,   // at a vertex
    missed,     // a point of the input is too far from the result
    strayed,    // a point of the result's triangle `face` is too far from the input
    folded,     // the result's triangle `face`
    border_off  // a border between materials is too far from where it was
  };
  Kind kind;
  Vec3 place;
  double distance = 0;                     // where that is what is wrong [steps]
  std::uint32_t face = ~0U, vertex = ~0U;  // `missed`: a vertex to bring back
};

/// What a simplified surface was found to be.
struct Findings {
  double error = 0;           // largest distance within what is allowed [steps]
  std::vector<Fault> faults;  // past some number, not all
  bool torn = false;          // wrong as a whole: another Euler characteristic
  bool good() const { return faults.empty() && !torn; }
};

/// Turns edges of folded triangles where that unfolds them. A triangle is folded when nothing of
/// the input within `error` of its middle faces its way: the simplifier lets a triangle turn a
/// little with every step. Returns those that stay folded.
std::vector<Fault> unfold(const Original& input, Faces& faces, double error);

/// Topology: the same border edges with the same materials, the same fans, nothing degenerate or
/// doubled, no new chord along a border plane. Then distances both ways, and between material
/// borders. Ends early past `most_faults`.
Findings examine(const Original& input, const Faces& faces, double error, std::size_t most_faults);

/// Topology alone, as in `examine`.
Findings compare_topology(const Original& input, const Faces& faces, const HalfEdges& edges);

/// Mends faults one by one: brings a vertex of the input back where the surfaces are too far apart,
/// and merges a vertex of a folded triangle into a neighbour. What changed is examined again, and
/// mended again, some rounds at most. Returns the findings afterwards; faults of other kinds stay.
Findings repair(const Original& input, Faces& faces, double error, Findings findings);

}  // namespace hoodoo::lod
