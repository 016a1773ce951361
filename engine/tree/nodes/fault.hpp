#pragma once
#include "engine/tree/nodes/rotate.hpp"

namespace hoodoo::tree {

/// Geology with a dislocated part: rho(w^-1(p)) strictly inside a domain, rho(p) outside, where w
/// turns and then moves. The domain is where another tree, say a half-space, a box or a prism,
/// exceeds 1/2. Source: Paris et al. 2019, section 4.4.
struct Fault {
  static constexpr std::string_view type = "fault";
  static constexpr std::string_view doc =
      "Geology with a dislocated part: rho(w^-1(p)) strictly inside a domain, rho(p) outside; w "
      "turns, then moves.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 4.4";
  static constexpr Family family = Family::geology;
  static constexpr std::array slots{Slot{"child", "rho: the geology as it was.", 1, 1, false},
                                    Slot{"domain", "The part that moves: where its F exceeds 1/2.",
                                         1, 1, false, Family::terrain}};

  Vec3 by;  // [m]
  Vec3 axis{0, 0, 1};
  double angle = 0;  // [deg]
  Point pivot;

  static constexpr auto fields() {
    return std::tuple{Vector<Fault>{"by", &Fault::by, "m", within(-farthest, farthest), Vec3{},
                                    "How far the part has moved, along x, y and z."},
                      Number<Fault>{"angle", &Fault::angle, "deg", within(-360, 360), 0.0,
                                    "How far it was turned before."},
                      Direction<Fault>{"axis", &Fault::axis, Vec3{0, 0, 1},
                                       "Direction of the axis it turned on."},
                      Position<Fault>{"pivot", &Fault::pivot, Vec3{}, "A point of that axis."}};
  }
  Support support(std::span<const Support> children) const;
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;
  friend bool operator==(const Fault&, const Fault&) = default;
};

}  // namespace hoodoo::tree
