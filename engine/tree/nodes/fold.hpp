#pragma once
#include "engine/base/noise.hpp"
#include "engine/tree/dual.hpp"
#include "engine/tree/node_type.hpp"

namespace hoodoo::tree {

/// The child, folded along one direction: F(p) = F_1(p + a (2 t(p) - 1) fD(p) n), t turbulence, fD
/// the control field clamped to [0,1] (1 everywhere without one). Level strata become folds.
/// Source: Paris et al. 2019, section 4.3, about 0 as DESIGN section 3 asks.
struct Fold {
  static constexpr std::string_view type = "fold";
  static constexpr std::string_view doc =
      "The child, folded along one direction: F(p) = F_1(p + a (2 t(p) - 1) fD(p) n), t "
      "turbulence.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 4.3, about 0";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{
      Slot{"child", "What is folded.", 1, 1, false},
      Slot{"control", "fD: where and how much, in [0,1]; everywhere without it.", 0, 1, false}};

  double amplitude = 1;  // a [m]
  double wavelength = 100;
  int octaves = 1;
  std::uint32_t seed = 0;
  Vec3 direction{0, 0, 1};  // n

  static constexpr auto fields() {
    return std::tuple{
        Number<Fold>{"amplitude", &Fold::amplitude, "m", within(0, longest), required,
                     "How far a point moves at most."},
        Number<Fold>{"wavelength", &Fold::wavelength, "m", above(0, longest), 100.0,
                     "Size of the largest folds."},
        Whole<Fold>{"octaves", &Fold::octaves, 1, 12, 1, "Layers of detail, each half the size."},
        Whole<Fold, std::uint32_t>{"seed", &Fold::seed, 0, 4294967295LL, 0u, "Which folds."},
        Direction<Fold>{"direction", &Fold::direction, Vec3{0, 0, 1}, "Which way points move."}};
  }
  Support support(std::span<const Support> children) const {
    const double control = children.size() > 1 ? children[1].slope : 0;
    const double bend = amplitude * (2 * turbulence_slope(noise()) + control);
    const Support& child = children[0];
    return {child.influence.empty() ? child.influence : child.influence.grown(reach()), child.range,
            child.slope * (1 + bend)};
  }
  Turbulence noise() const { return {wavelength, octaves, seed}; }
  double reach() const { return amplitude; }
  Interval displacement_bounds(int axis, const Vec3& center, double around) const {
    const double a = amplitude * normalized(direction)[axis];
    if (a == 0) return {0, 0};
    return (turbulence_bounds(noise(), center, around) * 2 - Interval{1, 1}) * a;
  }

  void displacement(int axis, const Vec3& origin, const Points& at, std::span<float> out) const {
    const auto a = static_cast<float>(amplitude * normalized(direction)[axis]);
    if (a == 0) return std::fill(out.begin(), out.end(), 0.0F);
    turbulence(noise(), origin, at.x, at.y, at.z, out);
    for (float& v : out) v = a * (2 * v - 1);
  }
  void displacement_gradient(int axis, const Vec3& origin, const Points& at, std::span<float> out,
                             const Gradients& g) const {
    const auto a = static_cast<float>(amplitude * normalized(direction)[axis]);
    if (a == 0) {
      for (const auto& part : {out, g.x, g.y, g.z}) std::fill(part.begin(), part.end(), 0.0F);
      return;
    }
    turbulence_gradient(noise(), origin, at.x, at.y, at.z, out, g.x, g.y, g.z);
    for (float& v : out) v = a * (2 * v - 1);
    for (const auto& part : {g.x, g.y, g.z}) {
      for (float& v : part) v *= 2 * a;
    }
  }
  friend bool operator==(const Fold&, const Fold&) = default;
};

}  // namespace hoodoo::tree
