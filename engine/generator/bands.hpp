#pragma once
#include <cstdint>
#include <optional>
#include <tuple>

#include "engine/tree/fields.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::generator {

/// Layers finer than those of a scene's geology, that resist more and less in turn. Nearly level,
/// and about 20 times as long as they are thick.
struct Bands {
  double thickness = 5;  // [m]
  double contrast = 0.6;
  int octaves = 3;
  double waviness = 2;  // [m]

  static constexpr auto fields() {
    using T = Bands;
    using namespace tree;
    return std::tuple{
        Number<T>{"thickness", &T::thickness, "m", above(0, longest), 5.0, "Of the thickest."},
        Number<T>{"contrast", &T::contrast, "1", within(0, 10), 0.6,
                  "How much their resistances differ; 0: the scene's geology alone."},
        Whole<T>{"octaves", &T::octaves, 1, 8, 3,
                 "Sets of bands, each half as thick and half as strong."},
        Number<T>{"waviness", &T::waviness, "m", within(0, longest), 2.0,
                  "How far they bend up and down."}};
  }
};

/// A geology with bands added to it; its own resistance is 1/2 where there is none.
tree::Node banded(const std::optional<tree::Node>& geology, const Bands& bands, std::uint64_t seed);

}  // namespace hoodoo::generator
