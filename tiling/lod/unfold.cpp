#include "tiling/lod/examine.hpp"

namespace hoodoo::lod {

namespace {

/// One pass over the folded triangles; leaves in `folded` those that still are. False when it
/// turned nothing.
bool unfold_some(const Original& input, Faces& faces, std::vector<std::uint32_t>& folded,
                 double error) {
  const HalfEdges edges(faces.triangles, input.points.size());
  std::vector<bool> touched(faces.triangles.size());
  const auto in_border_plane = [&](std::uint32_t a, std::uint32_t b) {
    return (input.surface.planes[a] & input.surface.planes[b]) != 0;
  };
  const auto turn = [&](std::uint32_t t, std::uint32_t from, std::uint32_t to, std::uint32_t x) {
    const auto* partner = edges.find(to, from);
    if (partner == nullptr) return false;
    const std::uint32_t other = partner->triangle, y = partner->apex;
    if (touched[t] || touched[other] || faces.materials[t] != faces.materials[other] || x == y ||
        in_border_plane(x, y) || edges.find(x, y) || edges.find(y, x)) {
      return false;
    }
    const Turn turned{from, to, x, y};
    std::uint32_t hint = 0;
    if (!input.upright(turned.first(), error, hint) ||
        !input.upright(turned.second(), error, hint)) {
      return false;
    }
    faces.triangles[t] = turned.first();
    faces.triangles[other] = turned.second();
    touched[t] = touched[other] = true;
    return true;
  };
  std::vector<std::uint32_t> left;
  bool any = false;
  for (const auto t : folded) {
    const auto [a, b, c] = faces.triangles[t];
    if (turn(t, a, b, c) || turn(t, b, c, a) || turn(t, c, a, b)) {
      any = true;
    } else if (!touched[t]) {
      left.push_back(t);
    }
  }
  folded = std::move(left);
  return any;
}

}  // namespace

std::vector<Fault> unfold(const Original& input, Faces& faces, double error) {
  std::vector<std::uint32_t> folded;
  std::uint32_t hint = 0;
  for (std::uint32_t t = 0; t < faces.triangles.size(); ++t) {
    const auto& triangle = faces.triangles[t];
    if (!kept(triangle, input.edges) && !input.upright(triangle, error, hint)) folded.push_back(t);
  }
  constexpr int passes = 4;
  for (int pass = 0; pass < passes && !folded.empty(); ++pass) {
    if (!unfold_some(input, faces, folded, error)) break;
  }
  std::vector<Fault> faults;
  for (const auto t : folded) {
    const auto& [a, b, c] = faces.triangles[t];
    const auto& p = input.points;
    faults.push_back({Fault::Kind::folded, (p[a] + p[b] + p[c]) * (1.0 / 3), 0, t, ~0U});
  }
  return faults;
}

}  // namespace hoodoo::lod
