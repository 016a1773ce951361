#pragma once
#include <array>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/tree/fields.hpp"
#include "engine/tree/ground.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::scene {

/// How a brush joins what is there: names of tree::Operation, in its order.
inline constexpr std::array<std::string_view, 4> brush_operations = {"blend", "carve", "union",
                                                                     "difference"};

/// What every brush has beside its shape.
struct Stroke {
  tree::Operation op = tree::Operation::unite;
  tree::StarTurbulence turbulence;
};

template <class B>
constexpr auto stroke_fields(tree::Operation fallback) {
  return std::tuple{
      tree::Group<B, tree::StarTurbulence>{"turbulence", &B::turbulence,
                                           "Roughness of the surface."},
      tree::Choice<B, tree::Operation>{
          "op", &B::op, brush_operations, fallback,
          "Add with a smooth join (blend) or a sharp one (union), remove with a smooth edge "
          "(carve) or to the stated size exactly (difference)."}};
}

/// A corner of a tube and the tube's radius there [m].
struct Bead {
  Vec3 at;
  double radius;
};

/// The curve through `points` in their order, as a chain of short lines: a uniform Catmull-Rom
/// spline, the first and the last span bending as if the curve went straight on beyond them.
/// Lines are about as long as `radius` [m], never more than 16 for one span.
std::vector<Vec3> smooth_curve(const std::vector<Vec3>& points, double radius);

/// A tube of one radius [m] along a chain.
tree::Node tube(const std::vector<Vec3>& chain, double radius,
                const tree::StarTurbulence& turbulence);

/// A tube whose radius changes along the chain. Source of the union: each line is a capsule of its
/// mean radius, so the surface has steps as high as the radius differs between two lines.
tree::Node tube(const std::vector<Bead>& chain, const tree::StarTurbulence& turbulence);

/// Problems of a rough tube of this radius [m], as the nodes it is made of state them.
void check_tube(double radius, const tree::StarTurbulence& turbulence, const std::string& where,
                std::vector<Problem>& problems);

/// The places of fixed points.
std::vector<Vec3> places(const std::vector<tree::Point>& points);

}  // namespace hoodoo::scene
