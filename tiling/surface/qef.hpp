#pragma once
#include <array>
#include <span>

#include "engine/base/vector.hpp"

namespace hoodoo::surface {

/// Directions whose eigenvalue is below this much of the largest do not count.
inline constexpr double least_eigenvalue = 0.1;

/// A crossing in the frame of its cell, edges of length 1, and its unit normal.
struct Plane3 {
  Vec3 point, normal;
};
/// A crossing in the frame of a lattice face, and the part of its normal that lies in the face.
struct Line2 {
  std::array<double, 2> point, normal;
};

Vec3 mean_point(std::span<const Plane3> planes);

/// The point nearest to all `planes` in the least squares sense, as an offset from their `mean`.
/// Directions whose eigenvalue is below a tenth of the largest are left at the mean, so it does
/// not run off along flat ground. At least one plane. The same bits with every compiler.
/// Source: Ju, Losasso, Schaefer, Warren 2002, Dual Contouring of Hermite Data, section 2.3; the
/// pseudo-inverse about the mean: Lindstrom 2000, Out-of-Core Simplification.
Vec3 minimise(std::span<const Plane3> planes, const Vec3& mean);

/// The same for the two crossings of a segment in a lattice face. Normals need not be unit; those
/// that nearly vanish in the face do not count.
std::array<double, 2> minimise(const std::array<Line2, 2>& lines,
                               const std::array<double, 2>& mean);

}  // namespace hoodoo::surface
