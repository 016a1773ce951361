#include "tiling/surface/tables.hpp"

#include <numeric>

namespace hoodoo::surface {
namespace {

/// Offsets of a face's corners.
constexpr std::array<unsigned, 4> along_u{0, 1, 1, 0}, along_v{0, 0, 1, 1};

unsigned face_corner(unsigned face, unsigned k) {
  const std::size_t a = face / 2, u = next_axis(a), v = last_axis(a);
  return (face & 1) << a | along_u[k] << u | along_v[k] << v;
}

unsigned face_edge(unsigned face, unsigned k) {
  const auto a = face / 2, side = face & 1;
  const auto u = static_cast<unsigned>(next_axis(a)), v = static_cast<unsigned>(last_axis(a));
  // An edge along u has its own offsets along v, then a; one along v along a, then u.
  switch (k) {
    case 0:
      return 4 * u + 2 * side;
    case 1:
      return 4 * v + side + 2;
    case 2:
      return 4 * u + 1 + 2 * side;
    default:
      return 4 * v + side;
  }
}

bool is_crossed(unsigned mask, unsigned edge) {
  const std::size_t a = edge / 4;
  const unsigned low = (edge & 1) << next_axis(a) | (edge >> 1 & 1) << last_axis(a);
  return ((mask >> low ^ mask >> (low | 1U << a)) & 1) != 0;
}

unsigned face_corners(unsigned mask, unsigned face) {
  unsigned corners = 0;
  for (unsigned k = 0; k < 4; ++k) corners |= (mask >> face_corner(face, k) & 1) << k;
  return corners;
}

FaceCase pair_edges(unsigned corners, bool cut_off_solid) {
  FaceCase result;
  const auto bit = [&](int k) { return (corners >> (k & 3) & 1) != 0; };
  const bool ambiguous = corners == 0b0101 || corners == 0b1010;
  if (ambiguous) {
    for (int k = 0; k < 4; ++k) {
      if (bit(k) != cut_off_solid) continue;
      result.segments[static_cast<std::size_t>(result.count++)] = {(k + 3) & 3, k};
    }
    return result;
  }
  int found = 0;
  for (int k = 0; k < 4; ++k) {
    if (bit(k) == bit(k + 1)) continue;
    (found++ == 0 ? result.segments[0].first : result.segments[0].second) = k;
  }
  result.count = found / 2;
  return result;
}

/// Edges joined into loops through the faces (union-find with paths of at most 12).
class Loops {
 public:
  Loops() { std::iota(parent_.begin(), parent_.end(), 0U); }
  unsigned root(unsigned edge) const {
    while (parent_[edge] != edge) edge = parent_[edge];
    return edge;
  }
  void join(unsigned a, unsigned b) { parent_[root(a)] = root(b); }

 private:
  std::array<unsigned, 12> parent_{};
};

Case trace(unsigned mask, int flipped_face) {
  Loops loops;
  for (unsigned face = 0; face < 6; ++face) {
    const auto pairs = pair_edges(face_corners(mask, face), static_cast<int>(face) != flipped_face);
    for (int i = 0; i < pairs.count; ++i) {
      const auto& s = pairs.segments[static_cast<std::size_t>(i)];
      loops.join(face_edge(face, static_cast<unsigned>(s.first)),
                 face_edge(face, static_cast<unsigned>(s.second)));
    }
  }
  Case result;
  std::array<int, 12> sheet_of_root;
  sheet_of_root.fill(-1);
  for (unsigned edge = 0; edge < 12; ++edge) {
    result.sheet[edge] = -1;
    if (!is_crossed(mask, edge)) continue;
    int& sheet = sheet_of_root[loops.root(edge)];
    if (sheet < 0) sheet = result.sheets++;
    result.sheet[edge] = static_cast<std::int8_t>(sheet);
    auto& edges = result.edges[static_cast<std::size_t>(sheet)];
    edges = static_cast<std::uint16_t>(edges | 1U << edge);
  }
  for (unsigned face = 0; face < 6; ++face) {
    if (pair_edges(face_corners(mask, face), true).count < 2) continue;
    // Opposite edges of an ambiguous face are never in one segment.
    if (result.sheet[face_edge(face, 0)] == result.sheet[face_edge(face, 2)]) {
      result.bad_face = static_cast<int>(face);
    }
  }
  return result;
}

}  // namespace

FaceCase face_case(unsigned corners) { return pair_edges(corners, true); }

const std::array<Case, 256>& cases() {
  static const auto table = [] {
    std::array<Case, 256> t;
    for (unsigned mask = 0; mask < 256; ++mask) t[mask] = trace(mask, -1);
    return t;
  }();
  return table;
}

const std::array<Case, 256>& flipped_cases() {
  static const auto table = [] {
    std::array<Case, 256> t;
    for (unsigned mask = 0; mask < 256; ++mask) t[mask] = trace(mask, cases()[mask].bad_face);
    return t;
  }();
  return table;
}

}  // namespace hoodoo::surface
