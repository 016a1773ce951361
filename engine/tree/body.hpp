#pragma once
#include <optional>
#include <span>

#include "engine/dem/window.hpp"
#include "engine/tree/columns.hpp"
#include "engine/tree/ground.hpp"
#include "engine/tree/node_type.hpp"
#include "engine/tree/points.hpp"

namespace hoodoo::tree {

/// A height body compiled for one block: F = min(F_T, F_P), F_T = (1 + s(v / R)) / 2 with
/// v = h(x, y) + offset - z (its negative when inverted), F_P = (1 + s(d / R)) / 2 with d the
/// distance to the domain's edge, s(u) = (3u - u^3)/2 on u clamped to [-1, 1].
///
/// h is taken in double and made relative to the block before it becomes single precision. With
/// `slope_corrected` v is divided by sqrt(1 + |grad h|^2), which the gradient takes as constant
/// (its change would need the second derivatives of h).
class BodyField {
 public:
  BodyField(const HeightBody& body, const dem::Window& window, const Block& block);

  /// At most batch_size points.
  void values(const Points& at, std::span<float> out) const;
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const;
  /// The bits that `values` gives, row by row. What the columns hold is found if it is not known
  /// yet.
  void cube(const Cube& at, std::unique_ptr<Columns::OfBody>& known, CubeValues out) const;
  /// Rounded outward, within [0, 1]; exactly 0 or 1 where the block is that throughout.
  const Interval& bounds() const { return bounds_; }
  /// The elevations, if F > 1/2 exactly where z lies below them.
  const dem::Window* elevations() const;
  const HeightBody& body() const { return *body_; }

 private:
  struct Column;  // what all points of one (x, y) share
  Column column_at(float x, float y, bool with_gradient) const;
  struct Scattered;
  bool is_scattered(const Points& at) const;
  void scattered_values(const Points& at, std::span<float> out) const;
  void scattered_gradients(const Points& at, std::span<float> out, const Gradients& g) const;
  std::unique_ptr<Columns::OfBody> columns(const Cube& at) const;

  const HeightBody* body_;
  const dem::Window* window_;
  Vec3 origin_;
  bool cut_;  // the domain's edge is near
  Interval bounds_;
};

}  // namespace hoodoo::tree
