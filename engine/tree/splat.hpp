#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/noise.hpp"
#include "engine/tree/points.hpp"

namespace hoodoo::tree {

/// A ball near a block: what evaluation needs of it, relative to the block's origin.
struct SplatBall {
  float x, y, z;     // centre [m]
  float radius;      // of its surface [m]
  float reach;       // R [m]
  float per_square;  // 1 / R^2
  float energy;
};

/// The balls of one sum, in their order.
class SplatBalls {
 public:
  static constexpr std::size_t wide = 16;

  explicit SplatBalls(std::vector<SplatBall> list);
  const SplatBall& operator[](std::size_t i) const { return list_[i]; }
  std::span<const SplatBall> list() const { return list_; }

  /// One number of all of them, filled up to whole vectors with balls that reach nothing.
  std::vector<float> x, y, z, radius, per_square;

 private:
  std::vector<SplatBall> list_;
};

/// What the balls of one sum share.
struct SplatRule {
  bool thin;        // F = e g(r); else F = e g(max(0, r - radius + inset))
  float inset;      // 0.4542 R [m]
  float amplitude;  // of the turbulence [m]; 0: smooth
  PlacedTurbulence noise;
};

/// Sums the fields of `balls` in their order, each rounded as primitive_kernel.hpp has it: the same
/// bits as a blend of such nodes, on every instruction set. A ball's rows are found by the
/// arithmetic of the field itself, which grows with distance in single precision too, so that a row
/// left out is exactly 0. Those that are not are marked in `asked`, at 16 i + j.
void splat(const SplatBalls& balls, const SplatRule& rule, const Cube& at, CubeValues out,
           std::span<std::uint8_t, Cube::side * Cube::side> asked);
/// At most 256 points. Faster if points next to each other in the list are near each other.
void splat(const SplatBalls& balls, const SplatRule& rule, const Points& at, std::span<float> out);
/// The same bits in `out`, and the gradient.
void splat(const SplatBalls& balls, const SplatRule& rule, const Points& at, std::span<float> out,
           const Gradients& g);

}  // namespace hoodoo::tree
