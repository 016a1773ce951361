#include "tiling/lod/survey.hpp"

#include <cmath>

namespace hoodoo::lod {
namespace {

/// Distances below this share of the error allowed are not told apart.
constexpr double least_share = 1.0 / 64;

}  // namespace

std::uint32_t Survey::farthest_gone(const Triangle& triangle, const Buckets& result) const {
  std::uint32_t found = ~0U, hint = 0;
  double most = -1;
  for (const auto vertex : triangle) {
    if (!is_gone(vertex)) continue;
    const double distance2 = result.beyond(input_.points[vertex], 0, hint);
    if (distance2 > most) {
      most = distance2;
      found = vertex;
    }
  }
  return found;
}

void Survey::input_against_result(std::span<const std::uint32_t> which, const Buckets& result) {
  const auto& p = input_.points;
  Farthest farthest(error_, error_ * least_share);
  const auto missed = [&](const Vec3& place, std::uint32_t vertex) {
    findings_.faults.push_back(
        {Fault::Kind::missed, place, std::sqrt(farthest.last2()), ~0U, vertex});
  };
  constexpr std::uint32_t unseen = ~0U;
  std::vector<std::uint32_t> nearest(p.size(), unseen);  // of the vertices that are gone
  const auto is_near = [&](std::uint32_t vertex, std::uint32_t face) {
    return nearest[vertex] == face || std::ranges::count(faces_.triangles[face], vertex) > 0;
  };
  for (const auto t : which) {
    const auto& triangle = input_.surface.triangles[t];
    if (enough()) break;
    if (kept(triangle, edges_)) continue;
    std::uint32_t face = unseen;
    for (const auto vertex : triangle) {
      if (!is_gone(vertex)) continue;
      if (nearest[vertex] == unseen) {
        if (!farthest.look(p[vertex], result)) missed(p[vertex], vertex);
        nearest[vertex] = farthest.nearest();
      }
      face = nearest[vertex];
    }
    const auto& [a, b, c] = triangle;
    if (face != unseen && is_near(a, face) && is_near(b, face) && is_near(c, face)) continue;
    const Vec3 centre = (p[a] + p[b] + p[c]) * (1.0 / 3);
    if (!farthest.look(centre, result)) missed(centre, farthest_gone(triangle, result));
  }
  end(farthest);
}

void Survey::result_against_input(std::span<const std::uint32_t> which) {
  const auto& p = input_.points;
  Farthest farthest(error_, error_ * least_share);
  for (const auto face : which) {
    const auto& triangle = faces_.triangles[face];
    if (enough()) break;
    if (kept(triangle, input_.edges)) continue;
    const auto look = [&](const Vec3& sample) {
      if (farthest.look(sample, input_.buckets)) return;
      findings_.faults.push_back(
          {Fault::Kind::strayed, sample, std::sqrt(farthest.last2()), face, ~0U});
    };
    const auto& [a, b, c] = triangle;
    for_each_sample(p[a], p[b], p[c], sample_edges * input_.spacing, look);
    look((p[a] + p[b] + p[c]) * (1.0 / 3));
  }
  end(farthest);
}

void Survey::follow(const std::vector<Triangle>& from, const std::vector<Triangle>& to) {
  const auto& p = input_.points;
  const Buckets other(p, to, bucket_edges * input_.spacing);
  Farthest farthest(error_, error_ * least_share);
  const auto off = [&](const Vec3& place) {
    findings_.faults.push_back({Fault::Kind::border_off, place});
  };
  const auto look = [&](const Vec3& place) {
    if (!farthest.look(place, other)) off(place);
  };
  for (const auto& [a, b, end] : from) {
    if (enough()) break;
    if (other.empty()) {
      off(p[a]);
      continue;
    }
    look(p[a]);
    look(p[b]);
    for_each_sample(p[a], p[b], p[end], input_.spacing, look);
  }
  end(farthest);
}

void Survey::material_borders_both_ways() {
  const auto borders = material_borders(edges_, faces_.materials);
  follow(input_.borders, borders);
  follow(borders, input_.borders);
}

}  // namespace hoodoo::lod
