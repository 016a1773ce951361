#pragma once
#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Layer about a plane: rho = e g(d) + a t(p), d the distance to the plane, g the falloff of radius
/// R. The turbulence stands everywhere, not in the layer alone. Source: Paris et al. 2019, section
/// 4.2.
struct Plane {
  static constexpr std::string_view type = "plane";
  static constexpr std::string_view doc =
      "Layer about a plane: rho = e g(d) + a t(p), d the distance to the plane.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 4.2";
  static constexpr Family family = Family::geology;
  static constexpr auto slots = no_slots;

  Point point;
  Vec3 normal{0, 0, 1};
  double falloff = 10;  // R [m]
  double energy = 1;
  double amplitude = 0;  // a
  double wavelength = 10;
  int octaves = 3;
  std::uint32_t seed = 0;

  static constexpr auto fields() {
    return std::tuple{
        Position<Plane>{"point", &Plane::point, required, "A point of the plane."},
        Direction<Plane>{"normal", &Plane::normal, Vec3{0, 0, 1}, "Perpendicular to the plane."},
        Number<Plane>{"falloff", &Plane::falloff, "m", above(0, longest), 10.0,
                      "Distance at which the layer ends."},
        Number<Plane>{"energy", &Plane::energy, "1", within(-1000, 1000), 1.0,
                      "Resistance in the plane; negative is softer."},
        Number<Plane>{"amplitude", &Plane::amplitude, "1", within(-1000, 1000), 0.0,
                      "Strength of the added turbulence."},
        Number<Plane>{"wavelength", &Plane::wavelength, "m", above(0, longest), 10.0,
                      "Size of the largest irregularities."},
        Whole<Plane>{"octaves", &Plane::octaves, 1, 12, 3, "Layers of detail, each half the size."},
        Whole<Plane, std::uint32_t>{"seed", &Plane::seed, 0, 4294967295LL, 0u,
                                    "Which irregularities."}};
  }
  Turbulence noise() const { return {wavelength, octaves, seed}; }
  Support support(std::span<const Support>) const;
  void values(const Vec3& origin, const Points& at, std::span<float> out) const;
  void gradients(const Vec3& origin, const Points& at, std::span<float> out,
                 const Gradients& gradient) const;
  Interval bounds(const Block& block) const;
  friend bool operator==(const Plane&, const Plane&) = default;
};

}  // namespace hoodoo::tree
