#pragma once
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/interval.hpp"
#include "engine/base/vector.hpp"
#include "engine/tree/polygon.hpp"

namespace hoodoo::tree {

/// A painted grid of weights over [x0, x1] x [y0, y1] [m], bilinear between sample centres, held
/// beyond the outermost ones, 0 outside the rectangle.
struct Mask {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width = 0, height = 0;
  std::vector<float> weights;  // in [0,1], row by row from the south, x fastest
  friend bool operator==(const Mask&, const Mask&) = default;
};

/// Weight in [0,1] and its gradient [1/m].
struct Weight {
  double w;
  Vec3 gradient;
};

/// Where an operation acts: inside the polygon (if any) and the box and, by the mask's weight, on
/// the mask (if any). An altitude range is a box unbounded in x and y.
///
/// w = (1 + s(2 d / feather)) / 2, s(u) = (3u - u^3)/2 on u clamped to [-1, 1], d the signed
/// distance [m] to the edge of the polygon or box, whichever is nearer to being left; times the
/// mask. feather = 0 is a hard edge. Exactly 1 and 0 away from the edge.
struct Region {
  Polygon polygon;              // empty: not bounded by one
  Box box = Box::everywhere();  // infinite sides are no bound
  Mask mask;                    // width = 0: none
  double feather = 0;           // [m]

  Weight weight(const Vec3& p) const;
  /// Contains the weight at every point of `over`; exact where it is 0 or 1 throughout.
  Interval weights(const Box& over) const;
  /// Box outside which the weight is 0.
  Box influence() const;
  friend bool operator==(const Region&, const Region&) = default;
};

/// Canonical form; a mask by size and SHA-256 of its weights.
nlohmann::json to_json(const Region& region);

}  // namespace hoodoo::tree
