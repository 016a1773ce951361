#pragma once
#include "engine/tree/frustum.hpp"

namespace hoodoo::tree {

/// Right circular cone: F = e g(max(0, d + 0.4542 R)), d the exact signed distance to base and
/// mantle. Source: Paris et al. 2019, section 5.2; distance in the half-plane through the axis.
struct Cone : Volume {
  static constexpr std::string_view type = "cone";
  static constexpr std::string_view doc =
      "Right circular cone: F = e g(max(0, d + 0.4542 R)), d the signed distance to base and "
      "mantle.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (volumetric skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point base, tip;
  double radius = 1;  // [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Position<Cone>{"base", &Cone::base, required, "Centre of the base."},
                   Position<Cone>{"tip", &Cone::tip, required, "The tip."},
                   Number<Cone>{"radius", &Cone::radius, "m", above(0, longest), required,
                                "Radius of the base."}},
        volume_fields<Cone>());
  }
  /// Radius of the largest ball inside.
  double half_thickness() const {
    const double h = length(tip.value - base.value);
    return radius * h / (radius + std::sqrt(radius * radius + h * h));
  }
  Support support(std::span<const Support>) const {
    const Vec3 axis = normalized(tip.value - base.value);
    const auto across = [&](double a) { return radius * std::sqrt(std::max(0.0, 1 - a * a)); };
    const Vec3 disk{across(axis.x), across(axis.y), across(axis.z)};
    Box box{base.value - disk, base.value + disk};
    box.add(tip.value);
    return support_of(box);
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    if (base.form == tip.form && base.value == tip.value) {
      problems.push_back({where + "/tip", "must not be where the base is"});
    }
  }

  template <class S>
  struct Shape {
    S x, y, z, ax, ay, az;            // base, unit axis to the tip
    S radius, height, slant, nr, nh;  // |(radius, height)|, outward normal of the mantle

    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      const T dx = px - x, dy = py - y, dz = pz - z;
      const T h = dx * ax + dy * ay + dz * az;
      const T ex = dx - h * ax, ey = dy - h * ay, ez = dz - h * az;
      const T q = square_root(ex * ex + ey * ey + ez * ez);
      // (q, h) against the triangle (0, 0), (radius, 0), (0, height).
      const T mantle = (q - radius) * nr + h * nh;  // signed distance to the mantle's line
      const T along = (h * nr - (q - radius) * nh) / T(slant);  // 0 at the rim, 1 at the tip
      const T t = clamped(along, S(0), S(1));
      const T mq = radius - t * radius, mh = t * height;  // nearest point of the mantle
      const T bq = smaller(q, T(radius));                 // nearest of the base: (bq, 0)
      const T m2 = (q - mq) * (q - mq) + (h - mh) * (h - mh);
      const T b2 = (q - bq) * (q - bq) + h * h;
      const bool on_mantle = value_of(m2) < value_of(b2);
      const bool inside = value_of(mantle) <= S(0) && value_of(h) >= S(0);
      T d;
      if (on_mantle) {
        const bool face = value_of(along) > S(0) && value_of(along) < S(1);
        d = face ? mantle : inside ? -square_root(m2) : square_root(m2);
      } else {
        d = value_of(q) <= radius ? -h : square_root(b2);
      }
      const T vq = on_mantle ? mq : bq, vh = on_mantle ? mh : T(S(0));
      const T f = vq / larger(q, T(S(1e-12)));
      return {d, x + vh * ax + f * ex, y + vh * ay + f * ey, z + vh * az + f * ez};
    }
    Projection<Uncertain> project(const Uncertain& px, const Uncertain& py,
                                  const Uncertain& pz) const {
      const Uncertain dx = px - x, dy = py - y, dz = pz - z;
      const Uncertain h = dx * ax + dy * ay + dz * az;
      const Uncertain ex = dx - h * ax, ey = dy - h * ay, ez = dz - h * az;
      const Uncertain q = square_root(ex * ex + ey * ey + ez * ez);
      const Uncertain t = clamped((h * nr - (q - radius) * nh) / Uncertain(slant), 0, 1);
      const auto point = [&](const Uncertain& vq, const Uncertain& vh) {
        const Uncertain across = q - vq, up = h - vh;
        return ProfilePoint{across * across + up * up, vq, vh};
      };
      const auto nearest = nearest_of(
          {point(radius - t * radius, t * height), point(smaller(q, Uncertain(radius)), 0)});
      return turned(*this, nearest, q, {ex, ey, ez}, distance_over(*this, px, py, pz));
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    const Vec3 c = base.value - origin, u = tip.value - base.value;
    const Vec3 a = normalized(u);
    const double h = length(u), slant = std::max(std::sqrt(h * h + radius * radius), 1e-30);
    return {static_cast<S>(c.x),           static_cast<S>(c.y),
            static_cast<S>(c.z),           static_cast<S>(a.x),
            static_cast<S>(a.y),           static_cast<S>(a.z),
            static_cast<S>(radius),        static_cast<S>(h),
            static_cast<S>(slant),         static_cast<S>(h / slant),
            static_cast<S>(radius / slant)};
  }
  friend bool operator==(const Cone&, const Cone&) = default;
};

}  // namespace hoodoo::tree
