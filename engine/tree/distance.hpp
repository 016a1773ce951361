#pragma once
#include <vector>

#include "engine/tree/dual.hpp"
#include "engine/tree/node_type.hpp"

/// Distance trees: a family of their own, whose value is a distance in metres, negative inside.
/// Its leaves are the volumetric primitives, which give the distance to their surface there (with
/// their turbulence, without falloff and energy); its nodes are the distance operators and the
/// rigid transforms.
namespace hoodoo::tree {

struct Node;
struct Compiled;

/// As `compile`, for a distance tree; there is always a kernel.
Compiled compile_distance(const Node& tree, const Block& block);

/// What is known of a distance tree: outside `influence` the distance is at least that to this box;
/// its slope. Its range is everything.
Support distance_support(const Node& tree);

/// The thickness [m] of its thickest part, about.
double thickest(const Node& tree);

/// The fillet of a union of distances: m^2 / (4 k), m = max(0, k - |a - b|). Source: Quilez 2013,
/// smooth minimum (polynomial); min(a, b) less it keeps a slope of 1.
template <class T>
T metric_fillet(const T& a, const T& b, double k) {
  const T m = larger(constant<T>(0), constant<T>(k) - magnitude(a - b));
  return (m * m) * constant<T>(0.25 / std::max(k, 1e-30));
}

}  // namespace hoodoo::tree
