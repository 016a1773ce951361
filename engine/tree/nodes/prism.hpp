#pragma once
#include <fmt/format.h>

#include "engine/tree/polygon.hpp"
#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Upright block over a polygon: F = e g(max(0, d + 0.4542 R)), d the exact signed distance to its
/// walls, floor and roof. Inside by the even-odd rule. Source: Paris et al. 2019, section 5.1 (the
/// prism) and 5.2; its field is 1 inside, as DESIGN section 3 normalises it.
struct Prism : Volume {
  static constexpr std::string_view type = "prism";
  static constexpr std::string_view doc =
      "Upright block over a polygon: F = e g(max(0, d + 0.4542 R)), d the signed distance to its "
      "walls, floor and roof.";
  static constexpr std::string_view cited = "Paris et al. 2019, sections 5.1 and 5.2";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Polygon outline;
  double bottom = 0, top = 1;  // [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Outline<Prism>{"outline", &Prism::outline, 3, 4096, "Corners [x, y]."},
                   Number<Prism>{"bottom", &Prism::bottom, "m", within(-farthest, farthest),
                                 required, "Height of the floor."},
                   Number<Prism>{"top", &Prism::top, "m", within(-farthest, farthest), required,
                                 "Height of the roof."}},
        volume_fields<Prism>());
  }
  Box solid() const {
    Box box = bounds(outline);
    box.min.z = bottom;
    box.max.z = top;
    return box;
  }
  /// Of the box: no less than the outline's.
  double half_thickness() const {
    const Vec3 size = solid().max - solid().min;
    return std::min({size.x, size.y, size.z}) / 2;
  }
  Support support(std::span<const Support>) const { return support_of(solid()); }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    if (!(bottom < top)) {
      problems.push_back(
          {where + "/top", fmt::format("must be above the bottom, {} m, got {}", bottom, top)});
    }
  }

  template <class S>
  struct Shape {
    struct Side {
      S x, y, ux, uy, inverse_length2;
    };
    std::vector<Side> sides;
    S middle, half;  // of its height

    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      using V = Scalar<T>;
      const Side* wall = &sides[0];
      V nearest = std::numeric_limits<S>::max();
      bool inside = false;
      const V vx = value_of(px), vy = value_of(py);
      for (std::size_t i = 0, n = sides.size(); i < n; ++i) {
        const Side &a = sides[i], &b = sides[i + 1 < n ? i + 1 : 0];
        const V t = held(a, vx, vy), ex = vx - a.x - t * a.ux, ey = vy - a.y - t * a.uy;
        const V d2 = ex * ex + ey * ey;
        if (d2 < nearest) {
          nearest = d2;
          wall = &a;
        }
        if ((a.y > vy) != (b.y > vy) && vx < a.x + (b.x - a.x) * ((vy - a.y) / (b.y - a.y))) {
          inside = !inside;
        }
      }
      const T t = held(*wall, px, py);
      const T wx = wall->x + t * wall->ux, wy = wall->y + t * wall->uy;
      const T r = beside(*wall, t, px, py);
      const T zero(S(0)), d = inside ? -r : r, w = magnitude(pz - middle) - half;
      const T over = larger(d, zero), above = larger(w, zero);
      const T distance = square_root(over * over + above * above) + smaller(larger(d, w), zero);
      // To the wall outside the outline, or where it is the nearest face; to floor or roof alike.
      const bool aside = value_of(d) > S(0) || value_of(w) <= value_of(d);
      const bool level = value_of(w) > S(0) || value_of(d) < value_of(w);
      const T end(value_of(pz) < middle ? middle - half : middle + half);
      return {distance, aside ? wx : px, aside ? wy : py, level ? end : pz};
    }

   private:
    /// Distance from a side, to whose nearest point `t` leads. Beside the side itself it is taken
    /// across, so that its gradient has a direction right at the wall, too.
    template <class T>
    static T beside(const Side& s, const T& t, const T& x, const T& y) {
      const T ex = x - s.x, ey = y - s.y;
      if (value_of(t) > S(0) && value_of(t) < S(1)) {
        const S across = std::sqrt(s.inverse_length2);
        return magnitude(ex * (s.uy * across) - ey * (s.ux * across));
      }
      const T fx = ex - t * s.ux, fy = ey - t * s.uy;
      return square_root(fx * fx + fy * fy);
    }
    /// Fraction of the way along a side of the point nearest to (x, y).
    template <class T>
    static T held(const Side& s, const T& x, const T& y) {
      return clamped(((x - s.x) * s.ux + (y - s.y) * s.uy) * s.inverse_length2, S(0), S(1));
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    Shape<S> shape;
    const std::size_t n = outline.size();
    for (std::size_t i = 0; i < n; ++i) {
      const auto &a = outline[i], &b = outline[(i + 1) % n];
      const double ux = b[0] - a[0], uy = b[1] - a[1], l2 = ux * ux + uy * uy;
      shape.sides.push_back({static_cast<S>(a[0] - origin.x), static_cast<S>(a[1] - origin.y),
                             static_cast<S>(ux), static_cast<S>(uy),
                             static_cast<S>(l2 > 0 ? std::min(1 / l2, 1e30) : 0.0)});
    }
    shape.middle = static_cast<S>((bottom + top) / 2 - origin.z);
    shape.half = static_cast<S>((top - bottom) / 2);
    return shape;
  }
  friend bool operator==(const Prism&, const Prism&) = default;
};

}  // namespace hoodoo::tree
