#pragma once
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/base/noise.hpp"
#include "engine/tree/dual.hpp"
#include "engine/tree/node_type.hpp"
#include "engine/tree/uncertain.hpp"

namespace hoodoo::tree {

/// Where the falloff g(r) = (1 - (r/R)^2)^3 is 1/2, in units of R: sqrt(1 - 2^(-1/3)) = 0.4542...
/// A primitive's field is shifted by it, so that the stated size is where the surface lies.
inline constexpr double half_falloff = 0.45420201894740653;

/// Largest slope of g(r) in units of 1/R: 6 / sqrt(5) (4/5)^2, at r = R / sqrt(5); rounded up.
inline constexpr double steepest_falloff = 1.7173003;

/// 1 / x^2 for evaluation in single precision, which holds no more than 10^38.
inline double inverse_square(double x) { return 1 / std::max(x * x, 1e-30); }

/// Star-shaped perturbation of a skeletal primitive by turbulence t on its unperturbed boundary:
/// a volume's distance becomes d - a (2t - 1), a thin skeleton's radius of influence R + a (2t -
/// 1). Source: Paris et al. 2019, section 5.2, as DESIGN section 3 mends it.
struct StarTurbulence {
  double amplitude = 0;  // a [m]
  double wavelength = 10;
  int octaves = 3;
  std::uint32_t seed = 0;

  static constexpr auto fields() {
    using T = StarTurbulence;
    return std::tuple{
        Number<T>{"amplitude", &T::amplitude, "m", within(0, longest), 0.0,
                  "How far the boundary moves at most; 0 is smooth."},
        Number<T>{"wavelength", &T::wavelength, "m", above(0, longest), 10.0,
                  "Size of the largest bumps."},
        Whole<T>{"octaves", &T::octaves, 1, 12, 3, "Layers of detail, each half the size."},
        Whole<T, std::uint32_t>{"seed", &T::seed, 0, 4294967295LL, 0u, "Which bumps."}};
  }
  Turbulence noise() const { return {wavelength, octaves, seed}; }
  friend bool operator==(const StarTurbulence&, const StarTurbulence&) = default;
};

/// What every skeletal primitive has beside its geometry.
struct Skeletal {
  double energy = 1;  // e [1]
  StarTurbulence turbulence;
  friend bool operator==(const Skeletal&, const Skeletal&) = default;
};

template <class N>
constexpr auto skeletal_fields() {
  return std::tuple{
      Number<N>{"energy", &N::energy, "1", within(-1000, 1000), 1.0,
                "Strength of the field; negative removes in a blend."},
      Group<N, StarTurbulence>{"turbulence", &N::turbulence, "Roughness of the boundary."}};
}

/// Geometry of a thin skeleton: point, segment, curve. F = e g(r), r the distance to the skeleton,
/// R = radius / 0.4542, so that the surface lies at `radius`.
struct Thin : Skeletal {
  static constexpr bool thin = true;
  double radius = 1;  // [m]

  /// R [m].
  double reach() const { return radius / half_falloff; }
  /// Support of the field around a skeleton lying in `skeleton`.
  Support support_of(const Box& skeleton) const;
  void check(const std::string& where, std::vector<Problem>& problems) const;
  friend bool operator==(const Thin&, const Thin&) = default;
};

template <class N>
constexpr auto thin_fields() {
  return std::tuple_cat(std::tuple{Number<N>{"radius", &N::radius, "m", above(0, longest), required,
                                             "Distance from the skeleton to the surface."}},
                        skeletal_fields<N>());
}

/// Geometry of a solid: sphere, box, cone, ellipsoid. F = e g(max(0, d + 0.4542 R)), d the signed
/// distance to the stated surface, R the falloff.
struct Volume : Skeletal {
  static constexpr bool thin = false;
  double falloff = 4;  // R [m]

  /// Support of the field of a solid lying in `solid`.
  Support support_of(const Box& solid) const;
  friend bool operator==(const Volume&, const Volume&) = default;
};

template <class N>
constexpr auto volume_fields() {
  return std::tuple_cat(
      std::tuple{Number<N>{"falloff", &N::falloff, "m", above(0, longest), 4.0,
                           "Width over which the field falls from its peak to 0."}},
      skeletal_fields<N>());
}

/// Distance of p from the skeleton point s, and the point `radius` away from s towards p.
/// On the skeleton itself that point is s.
template <class T>
Projection<T> star_projection(const T& px, const T& py, const T& pz, const T& sx, const T& sy,
                              const T& sz, Scalar<T> radius) {
  using S = Scalar<T>;
  const T dx = px - sx, dy = py - sy, dz = pz - sz;
  const T r = square_root(dx * dx + dy * dy + dz * dz);
  const T f = T(radius) / larger(r, T(S(1e-12)));
  return {r, sx + f * dx, sy + f * dy, sz + f * dz};
}

/// e (1 - r2/R2)^3, 0 where r2 >= R2; never -0. `r2` and R2 = 1 / `per_square` in square metres.
template <class T>
T falloff_of_square(const T& r2, Scalar<T> per_square, Scalar<T> energy) {
  using S = Scalar<T>;
  const T q = larger(T(S(0)), S(1) - r2 * per_square);
  return (q * q) * (q * energy) + S(0);
}

}  // namespace hoodoo::tree
