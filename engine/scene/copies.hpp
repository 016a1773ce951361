#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "engine/scene/fields.hpp"
#include "engine/tree/node.hpp"

/// What a brush or a tree makes besides itself: its image in a plane, and others like it.
/// Source: Paris et al. 2019, section 8.2 (brushes).
namespace hoodoo::scene {

class InputTerrain;  // points.hpp

/// "mirror" of an operation: what it makes stands on the other side of an upright plane, too.
struct MirrorSettings {
  static constexpr std::string_view doc =
      "An upright plane: all that the operation makes stands on its other side, too, as its image. "
      "Images keep their height; the ground under them is not asked.";

  Pair point{};
  double angle = 0;  // [deg]

  static constexpr auto fields() {
    using T = MirrorSettings;
    return std::tuple{
        Special<T, Pair>{"point", &T::point, plan_form, tree::required,
                         "A point [x, y] [m] of the plane."},
        tree::Number<T>{"angle", &T::angle, "deg", tree::within(-360, 360), 0.0,
                        "Along which direction it runs in plan, counter-clockwise from east."}};
  }
};

/// "variants" of an operation: further copies of what it makes, each its own place, turn, size and
/// seed.
struct VariantSettings {
  static constexpr std::string_view doc =
      "Further ones like it around it, each turned, scaled and roughened in its own way. They lie "
      "over the ground, or in it, as it does.";

  int count = 1;
  double spread = 1;      // [m]
  double rotation = 180;  // [deg]
  double least_scale = 0.8, most_scale = 1.25;
  std::uint32_t seed = 0;

  static constexpr auto fields() {
    using T = VariantSettings;
    using namespace tree;
    return std::tuple{
        Whole<T>{"count", &T::count, 1, 10'000, std::nullopt, "How many."},
        Number<T>{"spread", &T::spread, "m", above(0, longest), required,
                  "They lie anywhere within this distance of its middle, in plan."},
        Number<T>{"rotation", &T::rotation, "deg", within(0, 180), 180.0,
                  "They are turned about the upright by a random angle up to this, either way."},
        Number<T>{"least_scale", &T::least_scale, "1", within(0.01, 100), 0.8,
                  "They are scaled by a random factor from this on."},
        Number<T>{"most_scale", &T::most_scale, "1", within(0.01, 100), 1.25,
                  "The largest factor."},
        Whole<T, std::uint32_t>{"seed", &T::seed, 0, 4294967295LL, 0u,
                                "Of places, turns, sizes and roughness."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
};

/// Both, as an operation states them.
struct Copies {
  std::optional<MirrorSettings> mirror;
  std::optional<VariantSettings> variants;
};

/// Makes the tree of an operation once more, its seeds varied by the number. 0: as stated.
using Rebuild = std::function<tree::Node(std::uint64_t seed)>;

/// What the operation at `where` makes, copies included: one tree, in which what overlaps is
/// united. Variants come first, then the image of all of them. A variant over a hole is left out
/// and named in `warnings`. Errors: bad_input, where variants are asked of what has no middle or
/// stands over a hole.
tree::Node with_copies(const Rebuild& build, const Copies& copies, std::uint64_t seed,
                       const InputTerrain& terrain, const std::string& where,
                       std::vector<std::string>& warnings);

}  // namespace hoodoo::scene
