#pragma once
#include <cstdint>
#include <vector>

#include "tiling/lod/faces.hpp"
#include "tiling/surface/surface.hpp"

namespace hoodoo::lod {

/// The first target for the simplifier, as a share of the error allowed. Its own error is a mean
/// over areas: on fractal ground the largest distance is about twice that, so that at this share
/// most tiles are done at the first attempt.
inline constexpr double first_share = 0.45;

/// Edge collapse by meshoptimizer, which locks the border and moves material borders in one piece.
class Collapse {
 public:
  explicit Collapse(const surface::Surface& surface);

  /// Removes triangles while the simplifier's own error, a mean over areas, is below `target`
  /// steps. Triangles marked `frozen` stay, and so do their vertices.
  Faces run(double target, const std::vector<bool>& frozen) const;

 private:
  const surface::Surface& surface_;
  // Points split at material borders: the simplifier keeps vertices at one position together.
  std::vector<std::uint32_t> indices_;    // three per triangle, into `points_`
  std::vector<std::uint32_t> points_;     // -> point of the surface
  std::vector<std::uint16_t> materials_;  // of each
  std::vector<float> positions_;
  float scale_;
};

}  // namespace hoodoo::lod
