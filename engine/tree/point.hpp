#pragma once
#include "engine/base/vector.hpp"

namespace hoodoo::tree {

/// A position as a scene states it. JSON: `[x, y, z]`, or `{"xy": [x, y], "ground": dz}`, or
/// `{"uv": [u, v], "ground": dz}` with uv a fraction of the first terrain's extent; the last two
/// lie dz [m] above the input terrain. A ground point is turned into a fixed one by whoever has the
/// elevations (engine/scene), in the node's own coordinates: transforms around the node do not
/// move where its ground is looked up. Evaluation sees fixed points only.
struct Point {
  enum class Form { fixed, ground_xy, ground_uv };
  Form form = Form::fixed;
  Vec3 value;  // fixed: x, y, z [m]; ground_xy: x, y, dz [m]; ground_uv: u, v [1], dz [m]

  Point() = default;
  Point(const Vec3& at) : value(at) {}  // NOLINT(google-explicit-constructor): a place is a point
  Point(Form how, const Vec3& numbers) : form(how), value(numbers) {}
  friend bool operator==(const Point&, const Point&) = default;
};

}  // namespace hoodoo::tree
