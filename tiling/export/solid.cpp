#include "tiling/export/solid.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "engine/base/error.hpp"
#include "tiling/lod/half_edges.hpp"

namespace hoodoo::exporting {
namespace {

/// An open edge in its plane: from low to high along it.
struct Segment {
  double from, to;      // along the plane [m]
  double z_from, z_to;  // [m]
  bool backward;        // its face runs along it from high to low

  double z(double along) const {
    if (along == from) return z_from;
    if (along == to) return z_to;
    return z_from + (z_to - z_from) * ((along - from) / (to - from));
  }
};

/// An upright plane: the axis it crosses, and where.
using Plane = std::pair<int, double>;

/// Where the solid at the floor begins or ends, crossing a line of constant y.
struct Side {
  double from, to;  // along y [m]
  double x;
};

class Closing {
 public:
  Closing(tileset::Patch& patch, double floor) : patch_(patch), floor_(floor) {}

  bool run() {
    gather();
    if (planes_.empty()) return false;
    for (auto& [plane, segments] : planes_) wall(plane, segments);
    lay_floor();
    return true;
  }

 private:
  void gather() {
    const lod::HalfEdges edges(patch_.triangles, patch_.points.size());
    for (const auto& open : lod::topology(patch_.triangles, edges).open) {
      const Vec3 &a = patch_.points[open.from], &b = patch_.points[open.to];
      const int across = a.x == b.x ? 0 : 1, along = 1 - across;
      if (a[across] != b[across]) {
        throw Error(Fault::bad_input, "", "a tile ends elsewhere than at its border");
      }
      if (a[along] == b[along]) continue;  // upright: it bounds no part of a plane
      const bool backward = a[along] > b[along];
      const Vec3 &low = backward ? b : a, &high = backward ? a : b;
      planes_[{across, a[across]}].push_back({low[along], high[along], low.z, high.z, backward});
    }
  }

  /// Strips between neighbouring corners, where the segments stand one over another: from the air
  /// above, the first is where the solid begins, the second where it ends, and so on.
  void wall(const Plane& plane, std::vector<Segment>& segments) {
    std::vector<double> stops;
    for (const auto& s : segments) {
      stops.push_back(s.from);
      stops.push_back(s.to);
    }
    std::ranges::sort(stops);
    stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
    std::ranges::sort(segments, {}, &Segment::from);
    std::vector<Segment> here;
    auto next = segments.begin();
    for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
      const double low = stops[i], high = stops[i + 1], middle = (low + high) / 2;
      std::erase_if(here, [&](const Segment& s) { return s.to <= low; });
      for (; next != segments.end() && next->from <= low; ++next) here.push_back(*next);
      std::ranges::sort(here, std::greater(), [&](const Segment& s) { return s.z(middle); });
      for (std::size_t k = 0; k < here.size(); k += 2) {
        const bool to_floor = k + 1 == here.size();
        const auto bottom = [&](double at) { return to_floor ? floor_ : here[k + 1].z(at); };
        const Segment& top = here[k];
        strip(plane, low, high, {top.z(low), top.z(high)}, {bottom(low), bottom(high)},
              top.backward);
      }
      if (here.size() % 2 == 1 && plane.first == 0) sides_.push_back({low, high, plane.second});
    }
  }

  /// A trapezoid in the plane, that turns its face where the surface above ends.
  void strip(const Plane& plane, double low, double high, std::pair<double, double> top,
             std::pair<double, double> bottom, bool backward) {
    const auto at = [&](double along, double z) {
      return plane.first == 0 ? Vec3{plane.second, along, z} : Vec3{along, plane.second, z};
    };
    const Vec3 a = at(low, top.first), b = at(high, top.second), c = at(high, bottom.second),
               d = at(low, bottom.first);
    if (backward) {
      quad(a, b, c, d);
    } else {
      quad(b, a, d, c);
    }
  }

  void quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const auto first = static_cast<std::uint32_t>(patch_.points.size());
    patch_.points.insert(patch_.points.end(), {a, b, c, d});
    const auto triangle = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
      const auto &p = patch_.points[first + i], &q = patch_.points[first + j],
                 &r = patch_.points[first + k];
      if (cross(q - p, r - p) != Vec3{}) {
        patch_.triangles.push_back({first + i, first + j, first + k});
      }
    };
    triangle(0, 1, 2);
    triangle(0, 2, 3);
  }

  /// Bands of constant y, in which the sides come in pairs from west to east; equal bands are one.
  void lay_floor() {
    std::vector<double> stops;
    for (const auto& side : sides_) {
      stops.push_back(side.from);
      stops.push_back(side.to);
    }
    std::ranges::sort(stops);
    stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
    std::ranges::sort(sides_, {}, &Side::from);
    std::vector<Side> here;
    std::vector<double> band;
    double start = 0;
    auto next = sides_.begin();
    for (std::size_t i = 0; i < stops.size(); ++i) {
      std::erase_if(here, [&](const Side& side) { return side.to <= stops[i]; });
      for (; next != sides_.end() && next->from <= stops[i]; ++next) here.push_back(*next);
      std::vector<double> crossings;
      for (const auto& side : here) crossings.push_back(side.x);
      std::ranges::sort(crossings);
      if (crossings == band) continue;
      lay_band(band, start, stops[i]);
      band = std::move(crossings);
      start = stops[i];
    }
  }

  void lay_band(const std::vector<double>& crossings, double south, double north) {
    for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
      const double west = crossings[k], east = crossings[k + 1];
      quad({west, south, floor_}, {west, north, floor_}, {east, north, floor_},
           {east, south, floor_});
    }
  }

  tileset::Patch& patch_;
  const double floor_;
  std::map<Plane, std::vector<Segment>> planes_;
  std::vector<Side> sides_;
};

}  // namespace

bool close(tileset::Patch& patch, double floor) { return Closing(patch, floor).run(); }

}  // namespace hoodoo::exporting
