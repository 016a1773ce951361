#pragma once
#include <fmt/format.h>

#include <optional>
#include <vector>

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
      const auto [wall, inside] = wall_by(value_of(px), value_of(py));
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
    /// By every wall, floor or roof that is the nearest of some point. Which side of the walls the
    /// points are on is the same throughout where no wall passes between them.
    Projection<Uncertain> project(const Uncertain& px, const Uncertain& py,
                                  const Uncertain& pz) const {
      const auto walls = walls_by(px, py);
      const Uncertain& r = walls.distance;
      const bool inside = wall_by(px.middle(), py.middle()).inside;
      const Uncertain d = r.low <= 0 ? hull(-r, r) : inside ? -r : r;
      const Uncertain w = magnitude(pz - middle) - half, zero;
      const Uncertain over = larger(d, zero), above = larger(w, zero);
      const Uncertain distance =
          square_root(over * over + above * above) + smaller(larger(d, w), zero);
      const auto either = [](bool all, bool none, const Uncertain& a, const Uncertain& b) {
        return all ? a : none ? b : hull(a, b);
      };
      const bool aside = d.low > 0 || w.high <= d.low, not_aside = d.high <= 0 && w.low > d.high;
      const bool level = w.low > 0 || d.high < w.low, not_level = w.high <= 0 && d.low >= w.high;
      const Uncertain end =
          either(pz.high < middle, pz.low >= middle, middle - half, middle + half);
      return {distance, either(aside, not_aside, walls.x, px),
              either(aside, not_aside, walls.y, py), either(level, not_level, end, pz)};
    }

   private:
    struct Wall {
      const Side* nearest;
      bool inside;
    };
    template <class V>
    Wall wall_by(V x, V y) const {
      Wall wall{&sides[0], false};
      V nearest = std::numeric_limits<V>::max();
      for (std::size_t i = 0, n = sides.size(); i < n; ++i) {
        const Side &a = sides[i], &b = sides[i + 1 < n ? i + 1 : 0];
        const V t = held(a, x, y), ex = x - a.x - t * a.ux, ey = y - a.y - t * a.uy;
        const V d2 = ex * ex + ey * ey;
        if (d2 < nearest) {
          nearest = d2;
          wall.nearest = &a;
        }
        if ((a.y > y) != (b.y > y) && x < a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y))) {
          wall.inside = !wall.inside;
        }
      }
      return wall;
    }
    /// Distance from the outline and the nearest points of it.
    Projection<Uncertain> walls_by(const Uncertain& x, const Uncertain& y) const {
      std::vector<Projection<Uncertain>> feet;
      double most = std::numeric_limits<double>::infinity();
      for (const Side& side : sides) {
        const Uncertain t = held(side, x, y);
        const Uncertain ex = x - side.x - t * side.ux, ey = y - side.y - t * side.uy;
        const Uncertain r = square_root(ex * ex + ey * ey);
        feet.push_back({r, side.x + t * side.ux, side.y + t * side.uy, {}});
        most = std::min(most, r.high);
      }
      std::optional<Projection<Uncertain>> all;
      for (const auto& foot : feet) {
        if (foot.distance.low <= most) all = all ? hull(*all, foot) : foot;
      }
      all->distance.high = most;
      return *all;
    }
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
