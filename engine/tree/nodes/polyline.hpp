#pragma once
#include <optional>

#include "engine/tree/nodes/segment.hpp"

namespace hoodoo::tree {

/// Tube that falls off from a chain of line segments: F = e (1 - (r/R)^2)^3, r the distance to the
/// nearest segment, R = radius / 0.4542. Source: Paris et al. 2019, section 5.2 (curve skeletons).
struct Polyline : Thin {
  static constexpr std::string_view type = "polyline";
  static constexpr std::string_view doc =
      "Tube that falls off from a chain of line segments: F = e (1 - (r/R)^2)^3, "
      "R = radius / 0.4542.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (curve skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  std::vector<Point> points;
  bool closed = false;

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Positions<Polyline>{"points", &Polyline::points, 2, 100'000, "The corners."},
                   Flag<Polyline>{"closed", &Polyline::closed, false,
                                  "The last corner is joined to the first."}},
        thin_fields<Polyline>());
  }
  Support support(std::span<const Support>) const {
    Box box;
    for (const Point& p : points) box.add(p.value);
    return support_of(box);
  }

  template <class S>
  struct Shape {
    std::vector<Segment::Shape<S>> segments;

    template <class T>
    T distance_squared(const T& px, const T& py, const T& pz) const {
      T nearest = segments[0].distance_squared(px, py, pz);
      for (std::size_t i = 1; i < segments.size(); ++i) {
        nearest = smaller(nearest, segments[i].distance_squared(px, py, pz));
      }
      return nearest;
    }
    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      std::size_t best = 0;
      auto nearest = value_of(segments[0].distance_squared(px, py, pz));
      for (std::size_t i = 1; i < segments.size(); ++i) {
        const auto d = value_of(segments[i].distance_squared(px, py, pz));
        if (d < nearest) {
          nearest = d;
          best = i;
        }
      }
      return segments[best].project(px, py, pz);
    }
    /// By every segment that is the nearest of some point.
    Projection<Uncertain> project(const Uncertain& px, const Uncertain& py,
                                  const Uncertain& pz) const {
      const double most = distance_squared(px, py, pz).high;
      std::optional<Projection<Uncertain>> all;
      for (const auto& segment : segments) {
        if (segment.distance_squared(px, py, pz).low > most) continue;
        const auto one = segment.project(px, py, pz);
        all = all ? hull(*all, one) : one;
      }
      return *all;
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    Shape<S> chain;
    const std::size_t n = points.size();
    for (std::size_t i = 0; i + (closed ? 0 : 1) < n; ++i) {
      chain.segments.push_back(Segment::shape_between<S>(
          points[i].value - origin, points[(i + 1) % n].value - origin, radius));
    }
    return chain;
  }
  /// Drops from `chain` the segments that cannot matter in the block; false when none is left.
  template <class S>
  bool keep_near(Shape<S>& chain, const Block& block) const {
    const double reach = support_of({Vec3{}, Vec3{}}).influence.max.x;
    const std::size_t n = points.size();
    std::vector<Segment::Shape<S>> kept;
    for (std::size_t i = 0; i < chain.segments.size(); ++i) {
      Box box{points[i].value, points[i].value};
      box.add(points[(i + 1) % n].value);
      const double slack = 1e-6 * (length(box.min - block.origin) + length(box.max - box.min));
      if (box.grown(reach + slack).overlaps(block.box)) kept.push_back(chain.segments[i]);
    }
    chain.segments = std::move(kept);
    return !chain.segments.empty();
  }
  friend bool operator==(const Polyline&, const Polyline&) = default;
};

}  // namespace hoodoo::tree
