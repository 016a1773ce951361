#pragma once
#include <array>
#include <optional>
#include <string_view>

#include "engine/generator/grammar.hpp"
#include "engine/generator/growth.hpp"
#include "engine/generator/habitat.hpp"
#include "engine/tree/fields.hpp"

namespace hoodoo::generator {

namespace form {
nlohmann::json grammar_schema();
}
/// A grammar (grammar.hpp).
inline constexpr tree::Form<Stated> grammar_form{&form::read_stated, &form::grammar_schema};

enum class Preset { hoodoo, goblin, rock_spire, balanced_rock };

/// The grammar of a preset, in the form of a scene's.
std::string_view preset_grammar(Preset preset);

/// Hoodoos and goblins. They may stand where slope, drainage and altitude suit them: axioms are
/// Poisson-disk samples of the plane, each kept with the probability of its place. A grammar, whose
/// symbols read the resistance where they are, derives each of them to terminals, which flow into
/// one body.
/// Source: Paris et al. 2019, section 6.3, figures 5 and 21.
struct Hoodoos : Habitat {
  static constexpr std::string_view type = "hoodoos";
  static constexpr std::string_view doc =
      "Hoodoos, goblins, spires and balanced rocks: axioms where slope and drainage suit them, "
      "derived by a grammar whose symbols read the resistance of the rock where they stand.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 6.3";
  static constexpr std::array<std::string_view, 4> presets = {"hoodoo", "goblin", "rock_spire",
                                                              "balanced_rock"};
  static constexpr std::array<std::string_view, 3> joins = {"blend", "carve", "union"};

  Preset preset = Preset::hoodoo;
  Stated stated;                         // the grammar as the scene has it
  std::optional<double> height, radius;  // [m]
  std::optional<double> cap, waist;      // [1]
  double variation = 0.3;
  double distance = 8;                    // [m]
  std::optional<double> sparse_distance;  // [m]
  double probability = 1;
  double smoothness = 0.3;
  double crease = 0, crease_wavelength = 2;  // [m]
  double sink = 0.3;                         // [m]
  int depth = 64;
  tree::Operation op = tree::Operation::blend;
  std::uint32_t seed = 0;

  Grammar grammar;  // of `stated`, or of the preset

  static auto fields() {
    using T = Hoodoos;
    using namespace tree;
    return std::tuple_cat(
        std::tuple{
            Choice<T, Preset>{"preset", &T::preset, presets, Preset::hoodoo,
                              "Which grammar, where none is given: a column of uneven layers under "
                              "a cap, a squat bulb on a neck, a pointed spire of blocks, or a "
                              "boulder on a pedestal."},
            Special<T, Stated>{"grammar", &T::stated, grammar_form, Stated{},
                               "A grammar of the scene's own, in place of the preset's."},
            OptionalNumber<T>{"height", &T::height, "m", above(0, 1000),
                              "Parameter \"height\" of the grammar: of a hoodoo of mean size, over "
                              "the ground at its foot; by default the grammar's own."},
            OptionalNumber<T>{"radius", &T::radius, "m", above(0, 1000),
                              "Parameter \"radius\": of the foot, and the size s of the axiom; by "
                              "default the grammar's own, or 1 m."},
            OptionalNumber<T>{"cap", &T::cap, "1", above(0, 10),
                              "Parameter \"cap\": size of the cap as a share of the column's; by "
                              "default the grammar's own."},
            OptionalNumber<T>{"waist", &T::waist, "1", above(0, 10),
                              "Parameter \"waist\": how thin the column is where the rock is "
                              "weakest, as a share of where it is hardest; by default the "
                              "grammar's own."},
            Number<T>{"variation", &T::variation, "1", within(0, 0.95), 0.3,
                      "Sizes differ from hoodoo to hoodoo by up to this share."},
            Number<T>{"distance", &T::distance, "m", above(0, longest), 8.0,
                      "Least distance between two axioms."},
            OptionalNumber<T>{"sparse_distance", &T::sparse_distance, "m", above(0, longest),
                              "Least distance between two axioms where they hardly suit; by "
                              "default as everywhere."},
            Number<T>{"probability", &T::probability, "1", within(0, 1), 1.0,
                      "Share of the axioms that grow where everything suits."},
            Number<T>{"smoothness", &T::smoothness, "1", within(0, 1), 0.3,
                      "Difference of F across which parts flow into each other; 0 is a sharp "
                      "join."},
            Number<T>{"crease", &T::crease, "m", within(0, 100), 0.0,
                      "How far creases and cracks bend the surface."},
            Number<T>{"crease_wavelength", &T::crease_wavelength, "m", above(0, longest), 2.0,
                      "Size of the largest creases."},
            Number<T>{"sink", &T::sink, "m", within(0, longest), 0.3,
                      "How far the axiom lies below the lowest ground under the foot."},
            Whole<T>{"depth", &T::depth, 1, deepest_derivation, 64,
                     "Most steps of derivation; symbols that are left then are left out."},
            Choice<T, Operation>{"op", &T::op, joins, Operation::blend,
                                 "How the hoodoos join the ground: with a smooth foot (blend), a "
                                 "sharp one (union), or as holes (carve)."},
            Whole<T, std::uint32_t>{"seed", &T::seed, 0, 4294967295LL, 0u,
                                    "Of places, sizes and derivations."}},
        habitat_fields<T>());
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  /// Makes `grammar`.
  void read_trees(const std::string& where, const ReadTree& read, std::vector<Problem>& problems);
  void grow(Growth& growth) const;
};

}  // namespace hoodoo::generator
