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
      const auto [ax, ay, az, lowest] = squares();
      const T wx = rx * magnitude(dx), wy = ry * magnitude(dy), wz = rz * magnitude(dz);
      const S s = root_of(value_of(wx), value_of(wy), value_of(wz));
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
    /// The root grows with each of |dx|, |dy| and |dz|.
    Projection<Uncertain> project(const Uncertain& px, const Uncertain& py,
                                  const Uncertain& pz) const {
      const Uncertain dx = px - x, dy = py - y, dz = pz - z;
      const Uncertain wx = rx * magnitude(dx), wy = ry * magnitude(dy), wz = rz * magnitude(dz);
      const auto [ax, ay, az, lowest] = squares();
      const Uncertain root(root_of(wx.low, wy.low, wz.low) * (1 - 1e-5),
                           root_of(wx.high, wy.high, wz.high) * (1 + 1e-5));
      const auto part = [](const Uncertain& v) { return clamped(v, 0, 1); };
      Uncertain ux = part(wx / (root + ax)), uy = part(wy / (root + ay)),
                uz = part(wz / (root + az));
      lift(ux, uy, uz);
      return {distance_over(*this, px, py, pz), x + signed_as(rx * ux, dx),
              y + signed_as(ry * uy, dy), z + signed_as(rz * uz, dz)};
    }

   private:
    /// In s = t + least^2, with a_i = r_i^2 - least^2, each term is (r_i |d_i| / (s + a_i))^2.
    struct Squares {
      S ax, ay, az, lowest;  // the last: of s
    };
    Squares squares() const {
      const S l2 = least * least;
      return {rx * rx - l2, ry * ry - l2, rz * rz - l2, S(1e-4) * l2};
    }
    S root_of(S wx, S wy, S wz) const {
      const auto [ax, ay, az, lowest] = squares();
      S s = std::max({lowest, wx - ax, wy - ay, wz - az});
      for (int step = 0; step < 8; ++step) {
        s = std::max(lowest, newton(s, ax, ay, az, wx, wy, wz));
      }
      return s;
    }
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
    void lift(Uncertain& ux, Uncertain& uy, Uncertain& uz) const {
      const Uncertain rest = 1.0 - (ux * ux + uy * uy + uz * uz);
      if (rest.high < 1e-3) return;
      Uncertain& u = least == rz ? uz : least == ry ? uy : ux;
      const Uncertain lifted = clamped(square_root(u * u + clamped(rest, 0, 1)), 0, 1);
      u = rest.low >= 1e-3 ? lifted : hull(u, lifted);
    }
    template <class T>
    static T signed_as(const T& v, const T& d) {
      return value_of(d) < S(0) ? -v : v;
    }
    static Uncertain signed_as(const Uncertain& v, const Uncertain& d) {
      return d.low >= 0 ? v : d.high < 0 ? -v : hull(-v, v);
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
