#include "tiling/lod/examine.hpp"

namespace hoodoo::lod {

bool Examiner::upright(const Triangle& triangle, double error, std::uint32_t& hint) const {
  const Vec3 &a = points_[triangle[0]], &b = points_[triangle[1]], &c = points_[triangle[2]];
  const Vec3 middle = (a + b + c) * (1.0 / 3), normal = cross(b - a, c - a);
  return dot(normal, normal) > 0 && buckets_.faces(middle, error, normal, hint);
}

/// One pass over the folded triangles; leaves in `folded` those that still are. False when it
/// turned nothing.
bool Examiner::unfold_some(Faces& faces, std::vector<std::uint32_t>& folded, double error) const {
  const HalfEdges edges(faces.triangles, points_.size());
  std::vector<bool> touched(faces.triangles.size());
  const auto in_border_plane = [&](std::uint32_t a, std::uint32_t b) {
    return (surface_.planes[a] & surface_.planes[b]) != 0;
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
    if (!upright(turned.first(), error, hint) || !upright(turned.second(), error, hint)) {
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

std::vector<Vec3> Examiner::unfold(Faces& faces, double error) const {
  std::vector<std::uint32_t> folded;
  std::uint32_t hint = 0;
  for (std::uint32_t t = 0; t < faces.triangles.size(); ++t) {
    if (!kept(faces.triangles[t], edges_) && !upright(faces.triangles[t], error, hint)) {
      folded.push_back(t);
    }
  }
  constexpr int passes = 4;
  for (int pass = 0; pass < passes && !folded.empty(); ++pass) {
    if (!unfold_some(faces, folded, error)) break;
  }
  std::vector<Vec3> middles;
  for (const auto t : folded) {
    const auto& [a, b, c] = faces.triangles[t];
    middles.push_back((points_[a] + points_[b] + points_[c]) * (1.0 / 3));
  }
  return middles;
}

}  // namespace hoodoo::lod
