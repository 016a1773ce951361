#pragma once
#include <string_view>

#include "engine/generator/growth.hpp"
#include "engine/tree/fields.hpp"

namespace hoodoo::generator {

/// A smoothing brush: inside its region F gives way to a mean of the scene so far, so that ridges,
/// steps and thin parts narrower than about `size` round off, walls and ceilings as well as ground.
/// G(p) is the mean of F with weights k(x) k(y) k(z), k(t) = (1 - (t / size)^2)^3: what stands
/// alone shrinks, hollows fill, as under flow by mean curvature.
///
/// F is sampled on a lattice through the frame's origin, its step the scene's spacing, or as many
/// times twice that as keep `size` within 8 steps. G is kept as voxels there and stands in place of
/// F with the region's weight. The samples are those of blocks of the lattice, so that what is made
/// depends on the scene and the region alone.
///
/// Errors: bad_input where `size` is less than two spacings; limit where the region takes more
/// memory than the site may spend.
/// Source: Merriman, Bence, Osher 1992, Diffusion generated motion by mean curvature; the brush:
/// Paris et al. 2019, section 8.2.
struct Smooth {
  static constexpr std::string_view type = "smooth";
  static constexpr std::string_view doc =
      "Rounds off what is there: inside the region the field gives way to its own mean over "
      "`size`, so that ridges, steps and thin parts melt and notches fill, on walls and ceilings, "
      "too.";
  static constexpr std::string_view cited =
      "Merriman, Bence, Osher 1992, Diffusion generated motion by mean curvature; Paris et al. "
      "2019, section 8.2 (brushes)";

  double size = 8;  // [m]

  static constexpr auto fields() {
    using T = Smooth;
    using namespace tree;
    return std::tuple{Number<T>{"size", &T::size, "m", above(0, 1000), 8.0,
                                "How far from a place the mean reaches; what is narrower goes. At "
                                "least two spacings."}};
  }
  void grow(Growth& growth) const;
};

}  // namespace hoodoo::generator
