#pragma once
#include <vector>

#include "engine/base/box.hpp"
#include "engine/scene/picture.hpp"
#include "tiling/tileset/patch.hpp"

namespace hoodoo::compare {

/// A surface with a distance at each point [m]; negative where it has none.
struct Shaded {
  tileset::Patch patch;
  std::vector<double> distances;
};

/// Draws what of `surface` has distances, from the south-west and above in parallel projection, so
/// that `frame` fills the picture. Colours go from grey at 0 over yellow to red at `worst` [m].
scene::Picture draw(const Shaded& surface, const Box& frame, double worst);

}  // namespace hoodoo::compare
