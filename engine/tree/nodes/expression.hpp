#pragma once
#include "engine/base/error.hpp"
#include "engine/base/noise.hpp"
#include "engine/tree/formula.hpp"
#include "engine/tree/node_type.hpp"

namespace hoodoo::tree {

/// A formula over x, y, z [m] and named parameters (formula.hpp), evaluated in double at the place
/// in the scene, the result held to [-1000, 1000].
///
/// Every function is defined everywhere: a / 0 = 0; sqrt of what is negative is 0; log of what is
/// below 1e-30 is that of 1e-30; pow of a negative base is 0 unless the exponent is whole; sin and
/// cos hold their argument to 10^6; every value is held to +-1e30. Source: DESIGN section 3.
struct Expression {
  static constexpr std::string_view type = "expression";
  static constexpr std::string_view doc =
      "A formula over x, y, z in metres and named parameters: + - * / pow min max abs clamp mix "
      "smoothstep sin cos sqrt exp log floor noise fbm.";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  std::string formula;
  Parameters parameters;
  std::uint32_t seed = 0;

  static constexpr auto fields() {
    return std::tuple{
        Text<Expression>{"formula", &Expression::formula, required,
                         "For example \"smoothstep(40, 60, z) * fbm(x / 80, y / 80, z / 20, 4)\"."},
        Numbers<Expression>{"parameters", &Expression::parameters, 64, within(-1e30, 1e30),
                            "Names with their values."},
        Whole<Expression, std::uint32_t>{"seed", &Expression::seed, 0, 4294967295LL, 0u,
                                         "Which noise."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  Support support(std::span<const Support> children) const;
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;
  friend bool operator==(const Expression&, const Expression&) = default;
};

}  // namespace hoodoo::tree
