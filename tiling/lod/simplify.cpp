#include <algorithm>
#include <utility>

#include "tiling/lod/cluster.hpp"
#include "tiling/lod/collapse.hpp"
#include "tiling/lod/examine.hpp"
#include "tiling/lod/lod.hpp"

namespace hoodoo::lod {
namespace {

/// Clusters span so many cells, and may take this share of the error allowed, and of a cell.
constexpr int cluster_cells = 2;
constexpr double cluster_share = 0.1, cluster_most = 0.03;  // of the cells' side
/// After local faults: with part of the input frozen, everything else is collapsed in another
/// order, which brings faults elsewhere unless the target is smaller, too.
constexpr double next_share = 0.8;
constexpr int most_attempts = 6;
/// With more faults than this share of the triangles, the target was too large altogether.
constexpr double most_faulty = 0.02;
/// How far around a fault the input stays as it is, in typical edges.
constexpr double frozen_reach = 2;

Simplified compact(const surface::Surface& surface, const Faces& faces, double error) {
  Simplified result;
  result.error = error;
  constexpr std::uint32_t unused = ~0U;
  std::vector<std::uint32_t> renamed(surface.points.size(), unused);
  for (const auto& triangle : faces.triangles) {
    for (const auto point : triangle) renamed[point] = 0;
  }
  auto& out = result.surface;
  for (std::size_t i = 0; i < renamed.size(); ++i) {
    if (renamed[i] == unused) continue;
    renamed[i] = static_cast<std::uint32_t>(out.points.size());
    out.points.push_back(surface.points[i]);
    out.planes.push_back(surface.planes[i]);
  }
  out.materials = faces.materials;
  out.triangles.reserve(faces.triangles.size());
  for (const auto& [a, b, c] : faces.triangles) {
    out.triangles.push_back({renamed[a], renamed[b], renamed[c]});
  }
  return result;
}

Simplified collapse_edges(const Original& input, double error) {
  const auto& surface = input.surface;
  const Collapse collapse(surface);
  const auto most_faults =
      static_cast<std::size_t>(most_faulty * static_cast<double>(surface.triangles.size())) + 16;
  std::vector<bool> frozen(surface.triangles.size());
  double target = first_share * error, reach = frozen_reach * input.spacing;
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    Faces faces = collapse.run(target, frozen);
    drop_fins(faces, surface.points.size());
    turn_chords(faces, surface.planes);
    const auto folds = unfold(input, faces, error);
    Findings findings = examine(input, faces, error, most_faults);
    findings.faults.insert(findings.faults.end(), folds.begin(), folds.end());
    if (!findings.torn && findings.faults.size() <= most_faults) {
      findings = repair(input, faces, error, std::move(findings));
    }
    if (findings.good()) return compact(surface, faces, findings.error);
    if (findings.torn || findings.faults.size() > most_faults) {
      target *= 0.5;
      continue;
    }
    for (const auto& fault : findings.faults) {
      input.buckets.for_each_near(fault.place, error + reach,
                                  [&](std::uint32_t t) { frozen[t] = true; });
    }
    target *= next_share;
    reach *= 1.5;
  }
  return {surface, 0};
}

}  // namespace

Simplified simplify(const surface::Surface& surface, double error, int cell) {
  if (surface.triangles.empty() || !(error > 0)) return {surface, 0};
  const double share = std::min(cluster_share * error, cluster_most * cell);
  const auto clustered = cluster(surface, cluster_cells * cell, share);
  if (clustered) {
    const Original input(clustered->surface);
    if (same_topology(surface, *clustered, input.topology)) {
      auto result = collapse_edges(input, error - clustered->error);
      result.error += clustered->error;
      return result;
    }
  }
  return collapse_edges(Original(surface), error);
}

}  // namespace hoodoo::lod
