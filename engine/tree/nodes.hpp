#pragma once
#include <variant>

#include "engine/tree/nodes/bezier.hpp"
#include "engine/tree/nodes/blend.hpp"
#include "engine/tree/nodes/box.hpp"
#include "engine/tree/nodes/capsule.hpp"
#include "engine/tree/nodes/carve.hpp"
#include "engine/tree/nodes/catmull_rom.hpp"
#include "engine/tree/nodes/clamp.hpp"
#include "engine/tree/nodes/cone.hpp"
#include "engine/tree/nodes/cylinder.hpp"
#include "engine/tree/nodes/difference.hpp"
#include "engine/tree/nodes/distance_union.hpp"
#include "engine/tree/nodes/ellipsoid.hpp"
#include "engine/tree/nodes/erosion.hpp"
#include "engine/tree/nodes/expression.hpp"
#include "engine/tree/nodes/fault.hpp"
#include "engine/tree/nodes/fold.hpp"
#include "engine/tree/nodes/from_distance.hpp"
#include "engine/tree/nodes/grid.hpp"
#include "engine/tree/nodes/half_space.hpp"
#include "engine/tree/nodes/intersection.hpp"
#include "engine/tree/nodes/mirror.hpp"
#include "engine/tree/nodes/morph.hpp"
#include "engine/tree/nodes/multiply.hpp"
#include "engine/tree/nodes/offset.hpp"
#include "engine/tree/nodes/plane.hpp"
#include "engine/tree/nodes/point.hpp"
#include "engine/tree/nodes/points.hpp"
#include "engine/tree/nodes/polyline.hpp"
#include "engine/tree/nodes/prism.hpp"
#include "engine/tree/nodes/repeat.hpp"
#include "engine/tree/nodes/rotate.hpp"
#include "engine/tree/nodes/rounded_box.hpp"
#include "engine/tree/nodes/scale.hpp"
#include "engine/tree/nodes/segment.hpp"
#include "engine/tree/nodes/shell.hpp"
#include "engine/tree/nodes/smooth_difference.hpp"
#include "engine/tree/nodes/smooth_union.hpp"
#include "engine/tree/nodes/sphere.hpp"
#include "engine/tree/nodes/spheres.hpp"
#include "engine/tree/nodes/strata.hpp"
#include "engine/tree/nodes/stratum.hpp"
#include "engine/tree/nodes/taper.hpp"
#include "engine/tree/nodes/torus.hpp"
#include "engine/tree/nodes/translate.hpp"
#include "engine/tree/nodes/truncated_cone.hpp"
#include "engine/tree/nodes/twist.hpp"
#include "engine/tree/nodes/union.hpp"
#include "engine/tree/nodes/warp.hpp"

namespace hoodoo::tree {

/// Every node type there is. To add one: write nodes/<name>.hpp, name it here.
using AnyNode =
    std::variant<Blend, PointNode, Segment, Polyline, CatmullRom, Bezier, Sphere, BoxNode,
                 RoundedBox, Cone, TruncatedCone, Cylinder, Capsule, Torus, Ellipsoid, HalfSpace,
                 Prism, Carve, Union, Intersection, Difference, SmoothUnion, SmoothDifference,
                 Morph, Clamp, Multiply, Translate, Rotate, Scale, Mirror, Repeat, Warp, Fold,
                 Taper, Twist, Erosion, FromDistance, Offset, Shell, DistanceUnion, Strata, Stratum,
                 Plane, Fault, Expression, VoxelGrid, PointSet, SphereSet>;

/// A node type, and of exactly one kind of evaluation.
template <class N>
inline constexpr bool is_node = NodeType<N> &&
                                (Primitive<N> + Combiner<N> + Transform<N> + Displacement<N> +
                                 Pattern<N> + Composite<N> + Swarm<N>) == 1;

/// Whether a node may stand in a tree of a family.
template <class N>
constexpr bool stands_in(Family family) {
  if (family != Family::distance) return N::family == Family::any || N::family == family;
  return N::family == Family::distance || VolumePrimitive<N> || RigidTransform<N>;
}

template <class V>
inline constexpr bool all_nodes = false;
template <class... N>
inline constexpr bool all_nodes<std::variant<N...>> = (is_node<N> && ...);
static_assert(all_nodes<AnyNode>);

}  // namespace hoodoo::tree
