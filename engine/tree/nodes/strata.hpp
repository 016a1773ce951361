#pragma once
#include "engine/base/noise.hpp"
#include "engine/tree/node_type.hpp"

namespace hoodoo::tree {

/// Horizontal layers: rho = energy t(0, 0, z), t the turbulence of engine/base/noise.hpp.
/// Source: Paris et al. 2019, section 4.1; the line x = y = 0 embeds the height in space.
struct Strata {
  static constexpr std::string_view type = "strata";
  static constexpr std::string_view doc = "Horizontal layers: rho = energy t(0, 0, z).";
  static constexpr std::string_view cited = "Paris et al. 2019, section 4.1";
  static constexpr Family family = Family::geology;
  static constexpr auto slots = no_slots;

  double wavelength = 10;
  int octaves = 3;
  std::uint32_t seed = 0;
  double energy = 1;

  static constexpr auto fields() {
    return std::tuple{
        Number<Strata>{"wavelength", &Strata::wavelength, "m", above(0, longest), required,
                       "Thickness of the thickest layers."},
        Whole<Strata>{"octaves", &Strata::octaves, 1, 12, 3,
                      "Sets of layers, each half as thick and half as strong."},
        Whole<Strata, std::uint32_t>{"seed", &Strata::seed, 0, 4294967295LL, 0u, "Which layers."},
        Number<Strata>{"energy", &Strata::energy, "1", within(-1000, 1000), 1.0,
                       "Resistance of the hardest layer."}};
  }
  Turbulence noise() const { return {wavelength, octaves, seed}; }
  Support support(std::span<const Support>) const {
    return {Box::everywhere(), zero_to(energy), std::abs(energy) * turbulence_slope(noise())};
  }
  void values(const Vec3& origin, const Points& at, std::span<float> out) const;
  void gradients(const Vec3& origin, const Points& at, std::span<float> out,
                 const Gradients& gradient) const;
  Interval bounds(const Block& block) const;
  friend bool operator==(const Strata&, const Strata&) = default;
};

}  // namespace hoodoo::tree
