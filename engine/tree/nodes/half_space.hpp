#pragma once
#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Everything on one side of a plane: F = e g(max(0, d + 0.4542 R)), d = n . (p - point), n the
/// unit normal, which points out of the solid. Source: Paris et al. 2019, section 5.2 (volumetric
/// skeletons).
struct HalfSpace : Volume {
  static constexpr std::string_view type = "half_space";
  static constexpr std::string_view doc =
      "Everything behind a plane: F = e g(max(0, d + 0.4542 R)), d = n . (p - point).";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (volumetric skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point point;
  Vec3 normal{0, 0, 1};

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{
            Position<HalfSpace>{"point", &HalfSpace::point, required, "A point of the plane."},
            Direction<HalfSpace>{"normal", &HalfSpace::normal, Vec3{0, 0, 1},
                                 "Perpendicular to the plane, out of the solid."}},
        volume_fields<HalfSpace>());
  }
  double half_thickness() const { return Box::infinity; }
  Support support(std::span<const Support>) const {
    return {Box::everywhere(), zero_to(energy), support_of({Vec3{}, Vec3{}}).slope};
  }
  /// How far single precision may move the plane, seen from the block [m].
  double slack(const Block& block) const {
    const Vec3 far{std::max(block.box.max.x - block.origin.x, block.origin.x - block.box.min.x),
                   std::max(block.box.max.y - block.origin.y, block.origin.y - block.box.min.y),
                   std::max(block.box.max.z - block.origin.z, block.origin.z - block.box.min.z)};
    const double offset = dot(normalized(normal), block.origin - point.value);
    return 2e-6 * (length(far) + std::abs(offset) + falloff + turbulence.amplitude);
  }

  template <class S>
  struct Shape {
    S nx, ny, nz, offset;

    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      const T d = px * nx + py * ny + pz * nz + offset;
      return {d, px - d * nx, py - d * ny, pz - d * nz};
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    const Vec3 n = normalized(normal);
    return {static_cast<S>(n.x), static_cast<S>(n.y), static_cast<S>(n.z),
            static_cast<S>(dot(n, origin - point.value))};
  }
  friend bool operator==(const HalfSpace&, const HalfSpace&) = default;
};

}  // namespace hoodoo::tree
