#pragma once
#include <span>

#include "engine/base/noise.hpp"
#include "tests/bench/scene.hpp"

/// What the engine's arithmetic costs without an engine around it: loops written for one scene,
/// through Highway, with separate multiply and add.
namespace hoodoo::bench {

/// Balls of a scene by the columns of blocks they reach.
class Bins {
 public:
  explicit Bins(const Scene& scene, float grow = 0);
  std::span<const std::uint32_t> of(const BlockCorner& b) const;

 private:
  const Scene& scene_;
  std::vector<std::vector<std::uint32_t>> bins_;
};

/// Roughness of every ball: its reach becomes reach + amplitude (2 t - 1), t at `reach` from the
/// centre towards the point.
struct Rough {
  float amplitude = 0;
  Turbulence turbulence;
  float thickness = 1;  // where t is taken, in units of the reach
};

/// F of one block, x fastest: the height field and its balls, held in [0, 1].
void bare_splat(const Scene& scene, const Bins& bins, const BlockCorner& b, float* out);
void bare_rough_splat(const Scene& scene, const Bins& bins, const Rough& rough,
                      const BlockCorner& b, float* out);
/// Looks the elevations of a column of blocks up into the scene, as the engine has to.
void look_up(Scene& scene, const BlockCorner& b);
/// Turbulence at every point of a block, x fastest.
void bare_turbulence(const Turbulence& t, const BlockCorner& b, float* out);

}  // namespace hoodoo::bench
