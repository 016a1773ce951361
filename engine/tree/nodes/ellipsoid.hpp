#pragma once
#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Axis-aligned ellipsoid: F = e g(max(0, d + 0.4542 R)), d the signed distance to its surface.
///
/// d is found by Newton's method on sum (r_i p_i / (t + r_i^2))^2 = 1, a fixed number of steps from
/// the side where it converges monotonically (Eberly 2013, Distance from a Point to an Ellipse, an
/// Ellipsoid, or a Hyperellipsoid, section 4). Source: Paris et al. 2019, section 5.2.
struct Ellipsoid : Volume {
  static constexpr std::string_view type = "ellipsoid";
  static constexpr std::string_view doc =
      "Axis-aligned ellipsoid: F = e g(max(0, d + 0.4542 R)), d the signed distance to its "
      "surface.";
  static constexpr std::string_view cited =
      "Paris et al. 2019, section 5.2; distance after Eberly 2013";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point center;
  Vec3 radii{1, 1, 1};  // [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Position<Ellipsoid>{"center", &Ellipsoid::center, required, "Centre."},
                   Vector<Ellipsoid>{"radii", &Ellipsoid::radii, "m", above(0, longest), required,
                                     "Half axes along x, y and z."}},
        volume_fields<Ellipsoid>());
  }
  double half_thickness() const { return std::min({radii.x, radii.y, radii.z}); }
  Support support(std::span<const Support>) const {
    return support_of({center.value - radii, center.value + radii});
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    if (std::max({radii.x, radii.y, radii.z}) > 100 * half_thickness()) {
      problems.push_back({where + "/radii", "must not differ by more than a factor of 100"});
    }
  }

  template <class S>
  struct Shape {
    S x, y, z, rx, ry, rz, least;  // centre, half axes, the shortest of them

    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      const T dx = px - x, dy = py - y, dz = pz - z;
      // In s = t + least^2, with a_i = r_i^2 - least^2, each term is (r_i |d_i| / (s + a_i))^2.
      const S l2 = least * least, ax = rx * rx - l2, ay = ry * ry - l2, az = rz * rz - l2;
      const T wx = rx * magnitude(dx), wy = ry * magnitude(dy), wz = rz * magnitude(dz);
      const S lowest = S(1e-4) * l2;
      S s = std::max({lowest, value_of(wx) - ax, value_of(wy) - ay, value_of(wz) - az});
      for (int step = 0; step < 8; ++step) {
        s = std::max(lowest, newton(s, ax, ay, az, value_of(wx), value_of(wy), value_of(wz)));
      }
      // The last step carries the gradient: it is exact where the others have converged.
      const T root = larger(newton(T(s), ax, ay, az, wx, wy, wz), T(lowest));
      T ux = wx / (root + ax), uy = wy / (root + ay), uz = wz / (root + az);
      lift(ux, uy, uz);
      // Boundary point (r_i u_i), normal u_i / r_i.
      const T nx = ux * (1 / rx), ny = uy * (1 / ry), nz = uz * (1 / rz);
      const T norm = square_root(nx * nx + ny * ny + nz * nz);
      const T vx = rx * ux, vy = ry * uy, vz = rz * uz;
      const T d =
          ((magnitude(dx) - vx) * nx + (magnitude(dy) - vy) * ny + (magnitude(dz) - vz) * nz) /
          norm;
      return {d, x + signed_as(vx, dx), y + signed_as(vy, dy), z + signed_as(vz, dz)};
    }
    /// About the middle's: the nearest point of the boundary moves no faster than the point itself
    /// outside, and inside c / (c - depth) times as fast, c the least radius of curvature.
    Projection<Uncertain> project(const Uncertain& px, const Uncertain& py,
                                  const Uncertain& pz) const {
      const auto p = project<double>(px.middle(), py.middle(), pz.middle());
      const double off =
          std::sqrt(px.half() * px.half() + py.half() * py.half() + pz.half() * pz.half());
      const double curved = least * least / std::max({rx, ry, rz});
      const double depth = std::max(0.0, off - p.distance);
      if (depth > 0.9 * curved) Uncertain::note_undecided();
      const double moved = off * curved / std::max(curved - depth, 0.1 * curved);
      const auto about = [](double v, double by) { return Uncertain(v - by, v + by); };
      return {about(p.distance, off), about(p.x, moved), about(p.y, moved), about(p.z, moved)};
    }

   private:
    template <class T>
    static T newton(const T& s, S ax, S ay, S az, const T& wx, const T& wy, const T& wz) {
      const T ux = wx / (s + ax), uy = wy / (s + ay), uz = wz / (s + az);
      const T f = (ux * ux + uy * uy + uz * uz) - S(1);
      const T slope = ux * ux / (s + ax) + uy * uy / (s + ay) + uz * uz / (s + az);
      return s + f / larger(S(2) * slope, T(S(1e-30)));
    }
    /// Deep inside, where the plane across the shortest axis holds no root, the boundary point
    /// stands over it: the unit vector u is completed along that axis.
    template <class T>
    void lift(T& ux, T& uy, T& uz) const {
      const T rest = S(1) - (ux * ux + uy * uy + uz * uz);
      if (value_of(rest) < S(1e-3)) return;
      T& u = least == rz ? uz : least == ry ? uy : ux;
      u = square_root(u * u + rest);
    }
    template <class T>
    static T signed_as(const T& v, const T& d) {
      return value_of(d) < S(0) ? -v : v;
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    const Vec3 c = center.value - origin;
    const auto held = [](double r) { return static_cast<S>(std::max(r, 1e-12)); };
    return {static_cast<S>(c.x), static_cast<S>(c.y), static_cast<S>(c.z),   held(radii.x),
            held(radii.y),       held(radii.z),       held(half_thickness())};
  }
  friend bool operator==(const Ellipsoid&, const Ellipsoid&) = default;
};

}  // namespace hoodoo::tree
