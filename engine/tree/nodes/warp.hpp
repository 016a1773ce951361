#pragma once
#include "engine/base/noise.hpp"
#include "engine/base/random.hpp"
#include "engine/tree/dual.hpp"
#include "engine/tree/node_type.hpp"

namespace hoodoo::tree {

/// The child, bent by noise: F(p) = F_1(p + a delta(p) fD(p)), delta three decorrelated
/// turbulences 2 t - 1, fD the control field clamped to [0,1] (1 everywhere without one).
/// Source: Paris et al. 2019, section 5.3; three noises about 0 as DESIGN section 3 asks.
struct Warp {
  static constexpr std::string_view type = "warp";
  static constexpr std::string_view doc =
      "The child, bent by noise: F(p) = F_1(p + a delta(p) fD(p)), delta three turbulences 2 t - "
      "1.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.3, about 0";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{
      Slot{"child", "What is bent.", 1, 1, false},
      Slot{"control", "fD: where and how much, in [0,1]; everywhere without it.", 0, 1, false}};

  double amplitude = 1;  // a [m]
  double wavelength = 10;
  int octaves = 3;
  std::uint32_t seed = 0;

  static constexpr auto fields() {
    return std::tuple{
        Number<Warp>{"amplitude", &Warp::amplitude, "m", within(0, longest), required,
                     "How far a point moves along each axis at most."},
        Number<Warp>{"wavelength", &Warp::wavelength, "m", above(0, longest), 10.0,
                     "Size of the largest bends."},
        Whole<Warp>{"octaves", &Warp::octaves, 1, 12, 3, "Layers of detail, each half the size."},
        Whole<Warp, std::uint32_t>{"seed", &Warp::seed, 0, 4294967295LL, 0u, "Which bends."}};
  }
  Support support(std::span<const Support> children) const {
    const double control = children.size() > 1 ? children[1].slope : 0;
    const double bend = std::sqrt(3.0) * amplitude * (2 * turbulence_slope(noise(0)) + control);
    const Support& child = children[0];
    return {child.influence.empty() ? child.influence : child.influence.grown(reach()), child.range,
            child.slope * (1 + bend)};
  }
  Turbulence noise(int axis) const {
    return {wavelength, octaves, static_cast<std::uint32_t>(random_bits(seed, axis))};
  }
  double reach() const { return amplitude; }
  Interval displacement_bounds(int axis, const Vec3& center, double around) const {
    return (turbulence_bounds(noise(axis), center, around) * 2 - Interval{1, 1}) * amplitude;
  }

  void displacement(int axis, const Vec3& origin, const Points& at, std::span<float> out) const {
    turbulence(noise(axis), origin, at.x, at.y, at.z, out);
    const auto a = static_cast<float>(amplitude);
    for (float& v : out) v = a * (2 * v - 1);
  }
  void displacement_gradient(int axis, const Vec3& origin, const Points& at, std::span<float> out,
                             const Gradients& g) const {
    turbulence_gradient(noise(axis), origin, at.x, at.y, at.z, out, g.x, g.y, g.z);
    const auto a = static_cast<float>(amplitude);
    for (float& v : out) v = a * (2 * v - 1);
    for (const auto& part : {g.x, g.y, g.z}) {
      for (float& v : part) v *= 2 * a;
    }
  }
  friend bool operator==(const Warp&, const Warp&) = default;
};

}  // namespace hoodoo::tree
