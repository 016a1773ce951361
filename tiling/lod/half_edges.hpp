#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hoodoo::lod {

using Triangle = std::array<std::uint32_t, 3>;

/// The half-edges of a triangle list, found by the vertex they start from.
class HalfEdges {
 public:
  struct HalfEdge {
    std::uint32_t to, apex, triangle;  // from -> to -> apex is the triangle
  };

  /// `triangles` name vertices below `vertices`.
  HalfEdges(std::span<const Triangle> triangles, std::size_t vertices);

  std::size_t vertices() const { return first_.size() - 1; }
  std::span<const HalfEdge> from(std::uint32_t vertex) const {
    return {edges_.data() + first_[vertex], edges_.data() + first_[vertex + 1]};
  }
  /// The half-edge from `a` to `b`, the first if several; null if there is none.
  const HalfEdge* find(std::uint32_t a, std::uint32_t b) const {
    for (const auto& edge : from(a)) {
      if (edge.to == b) return &edge;
    }
    return nullptr;
  }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<HalfEdge> edges_;
};

/// The triangle is one of those that `edges` was made of.
inline bool kept(const Triangle& t, const HalfEdges& edges) {
  const auto* edge = edges.find(t[0], t[1]);
  return edge != nullptr && edge->apex == t[2];
}

/// What a triangle list is like where its triangles meet.
struct Topology {
  struct Open {
    std::uint32_t from, to, triangle;
    friend auto operator<=>(const Open&, const Open&) = default;
  };
  struct Fans {
    std::uint32_t vertex, count;
    friend auto operator<=>(const Fans&, const Fans&) = default;
  };
  std::vector<std::uint32_t> faulty;  // vertices of triangles that name one twice, of half-edges
                                      // used twice, of pairs of triangles on the same vertices
  std::vector<Open> open;             // half-edges without a partner, by vertex
  std::vector<Fans> split;            // vertices whose triangles are several fans, by vertex
  std::int64_t euler = 0;             // vertices in use - edges + triangles

  bool sound() const { return faulty.empty(); }
};
Topology topology(std::span<const Triangle> triangles, const HalfEdges& edges);

}  // namespace hoodoo::lod
