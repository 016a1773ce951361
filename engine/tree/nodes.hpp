#pragma once
#include <variant>

#include "engine/tree/nodes/blend.hpp"
#include "engine/tree/nodes/box.hpp"
#include "engine/tree/nodes/carve.hpp"
#include "engine/tree/nodes/cone.hpp"
#include "engine/tree/nodes/difference.hpp"
#include "engine/tree/nodes/ellipsoid.hpp"
#include "engine/tree/nodes/intersection.hpp"
#include "engine/tree/nodes/plane.hpp"
#include "engine/tree/nodes/point.hpp"
#include "engine/tree/nodes/points.hpp"
#include "engine/tree/nodes/polyline.hpp"
#include "engine/tree/nodes/rotate.hpp"
#include "engine/tree/nodes/scale.hpp"
#include "engine/tree/nodes/segment.hpp"
#include "engine/tree/nodes/smooth_difference.hpp"
#include "engine/tree/nodes/smooth_union.hpp"
#include "engine/tree/nodes/sphere.hpp"
#include "engine/tree/nodes/spheres.hpp"
#include "engine/tree/nodes/strata.hpp"
#include "engine/tree/nodes/translate.hpp"
#include "engine/tree/nodes/union.hpp"
#include "engine/tree/nodes/warp.hpp"

namespace hoodoo::tree {

/// Every node type there is. To add one: write nodes/<name>.hpp, name it here.
using AnyNode = std::variant<Blend, PointNode, Segment, Polyline, Sphere, BoxNode, Cone, Ellipsoid,
                             Carve, Union, Intersection, Difference, SmoothUnion, SmoothDifference,
                             Translate, Rotate, Scale, Warp, Strata, Plane, PointSet, SphereSet>;

/// A node type, and of exactly one kind of evaluation.
template <class N>
inline constexpr bool is_node = NodeType<N> && (Primitive<N> + Combiner<N> + Transform<N> +
                                                Displacement<N> + Pattern<N> + Swarm<N>) == 1;

template <class V>
inline constexpr bool all_nodes = false;
template <class... N>
inline constexpr bool all_nodes<std::variant<N...>> = (is_node<N> && ...);
static_assert(all_nodes<AnyNode>);

}  // namespace hoodoo::tree
