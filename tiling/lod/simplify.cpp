#include <utility>

#include "tiling/lod/collapse.hpp"
#include "tiling/lod/examine.hpp"
#include "tiling/lod/lod.hpp"

namespace hoodoo::lod {
namespace {

/// The first target for the simplifier, as a share of the error allowed. Its own error is a mean
/// over areas: on fractal ground the largest distance is about twice that, so that at this share
/// most tiles are done at the first attempt.
constexpr double first_share = 0.45;
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

}  // namespace

Simplified simplify(const surface::Surface& surface, double error) {
  if (surface.triangles.empty() || !(error > 0)) return {surface, 0};
  const Collapse collapse(surface);
  const Examiner examiner(surface);
  const auto most_faults =
      static_cast<std::size_t>(most_faulty * static_cast<double>(surface.triangles.size())) + 16;
  std::vector<bool> frozen(surface.triangles.size());
  double target = first_share * error, reach = frozen_reach * examiner.spacing();
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    Faces faces = collapse.run(target, frozen);
    drop_fins(faces, surface.points.size());
    turn_chords(faces, surface.planes);
    const auto folds = examiner.unfold(faces, error);
    Findings findings = examiner.examine(faces, error, most_faults);
    findings.faults.insert(findings.faults.end(), folds.begin(), folds.end());
    if (findings.good()) return compact(surface, faces, findings.error);
    if (findings.torn || findings.faults.size() > most_faults) {
      target *= 0.5;
      continue;
    }
    for (const auto& fault : findings.faults) examiner.mark(fault, error + reach, frozen);
    target *= next_share;
    reach *= 1.5;
  }
  return {surface, 0};
}

}  // namespace hoodoo::lod
