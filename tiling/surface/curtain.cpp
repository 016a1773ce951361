#include "tiling/surface/curtain.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace hoodoo::surface {
namespace {

using Point = std::array<std::int32_t, 3>;

constexpr double iso = 0.5;
constexpr unsigned x_planes = west | east, y_planes = south | north;

/// One of the four upright border planes, in the order of their Plane bits.
struct Side {
  int index;
  int axis() const { return index / 2; }
  Vec3 outward() const {
    Vec3 o;
    o[axis()] = index % 2 == 0 ? -1 : 1;
    return o;
  }
};

/// An edge of the border curve; the surface is on its left seen from the air.
struct RimEdge {
  Side side;
  std::array<std::uint32_t, 2> points;    // of the surface
  std::array<std::uint32_t, 2> vertices;  // of its mesh
  std::uint32_t triangle;                 // that it is an edge of
};

/// Edges of one triangle only, both ends on one side and not along the world's edge, in the order
/// of the triangles.
std::vector<RimEdge> rim_of(const Surface& surface, const Mesh& mesh) {
  std::vector<RimEdge> edges;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t l = (k + 1) % 3;
      const auto a = surface.triangles[t][k], b = surface.triangles[t][l];
      const unsigned common = surface.planes[a] & surface.planes[b];
      if ((common & (x_planes | y_planes)) == 0 || (common & world_edge) != 0) continue;
      ++uses[{std::min(a, b), std::max(a, b)}];
      const Side side{std::countr_zero(common)};
      edges.push_back({side,
                       {a, b},
                       {mesh.triangles[t][k], mesh.triangles[t][l]},
                       static_cast<std::uint32_t>(t)});
    }
  }
  std::erase_if(edges, [&](const RimEdge& e) {
    return uses.at({std::min(e.points[0], e.points[1]), std::max(e.points[0], e.points[1])}) != 1;
  });
  return edges;
}

Vec3 between(const Point& a, const Point& b) {
  return {static_cast<double>(b[0] - a[0]), static_cast<double>(b[1] - a[1]),
          static_cast<double>(b[2] - a[2])};
}

/// Hangs skirts from the rim of one surface.
class Hanger {
 public:
  Hanger(const Surface& surface, const Mesh& mesh, const Curtain& curtain)
      : surface_(surface), mesh_(mesh), curtain_(curtain), rim_(rim_of(surface, mesh)) {}

  Skirts run() {
    find_directions();
    find_lengths();
    for (const auto& edge : rim_) add_panel(edge);
    return std::move(out_);
  }

 private:
  /// Where the skirt of one side hangs from one point of the rim.
  struct Foot {
    Vec3 inward;
    Point bottom{};
  };
  using Key = std::pair<int, std::uint32_t>;  // side, point of the surface

  /// Along the inward normal of the rim in its plane, the mean of both edges'; straight up or down
  /// at a tile's corner, so that the skirts of both sides meet, and where the world ends.
  void find_directions() {
    for (const auto& edge : rim_) {
      const auto along = between(surface_.points[edge.points[0]], surface_.points[edge.points[1]]);
      const Vec3 inward = normalized(cross(along, edge.side.outward()));
      for (const auto point : edge.points) {
        auto& foot = feet_[{edge.side.index, point}];
        foot.inward = foot.inward + inward;
      }
    }
    for (auto& [key, foot] : feet_) {
      const unsigned planes = surface_.planes[key.second];
      const bool at_corner = (planes & x_planes) != 0 && (planes & y_planes) != 0;
      if (at_corner || (planes & world_edge) != 0) {
        foot.inward = {0, 0, foot.inward.z > 0 ? 1.0 : -1.0};
      }
      foot.inward = normalized(foot.inward, {0, 0, -1});
    }
  }

  /// The point `distance` steps down a foot, on its side and within the tile in plan.
  Point below(const Key& key, const Foot& foot, double distance) const {
    Point p = surface_.points[key.second];
    for (std::size_t a = 0; a < 3; ++a) {
      p[a] +=
          static_cast<std::int32_t>(std::floor(foot.inward[static_cast<int>(a)] * distance + 0.5));
      if (a < 2) p[a] = std::clamp(p[a], 0, curtain_.size);
    }
    return p;
  }

  /// Marches down every foot through twice the depth; the first air ends the solid.
  void find_lengths() {
    const int marks = static_cast<int>(std::ceil(2 * curtain_.depth / curtain_.stride));
    std::vector<slice::StepPoint> points;
    points.reserve(feet_.size() * static_cast<std::size_t>(marks));
    for (const auto& [key, foot] : feet_) {
      for (int i = 1; i <= marks; ++i) {
        const Point p = below(key, foot, i * curtain_.stride);
        points.push_back(
            {curtain_.origin[0] + p[0], curtain_.origin[1] + p[1], curtain_.origin[2] + p[2]});
      }
    }
    const auto values = curtain_.values(points);
    std::size_t first = 0;
    for (auto& [key, foot] : feet_) {
      const std::span march(values.data() + first, static_cast<std::size_t>(marks));
      foot.bottom = below(key, foot, std::min(curtain_.depth, 0.5 * thickness(march)));
      first += march.size();
    }
  }

  /// How far the solid goes on along a march that starts on the surface.
  double thickness(std::span<const float> march) const {
    double before = iso;
    for (std::size_t i = 0; i < march.size(); ++i) {
      const auto value = static_cast<double>(march[i]);
      if (value <= iso) {
        const double part = before > value ? (before - iso) / (before - value) : 0.0;
        return (static_cast<double>(i) + part) * curtain_.stride;
      }
      before = value;
    }
    return 2 * curtain_.depth;
  }

  /// A corner of a panel: the top or bottom of a foot, with the looks of the mesh's `like`.
  struct Corner {
    Point point;
    int side;
    std::uint32_t like;
    bool is_bottom;
    auto key() const { return std::tuple(side, like, is_bottom); }
  };

  void add_panel(const RimEdge& edge) {
    std::array<Corner, 2> top, bottom;
    for (std::size_t i = 0; i < 2; ++i) {
      const int side = edge.side.index;
      const auto point = edge.points[i], like = edge.vertices[i];
      top[i] = {surface_.points[point], side, like, false};
      bottom[i] = {feet_.at({side, point}).bottom, side, like, true};
    }
    add_triangle(edge, {top[1], top[0], bottom[0]});
    add_triangle(edge, {top[1], bottom[0], bottom[1]});
  }

  /// Where feet cross under a sharp ridge a panel folds over. Its part that faces into the tile is
  /// left out, since panels facing out cover the same; so is a triangle without area, where the
  /// solid is too thin for a skirt.
  void add_triangle(const RimEdge& edge, const std::array<Corner, 3>& corners) {
    const auto& [a, b, c] = corners;
    const Vec3 normal = cross(between(a.point, b.point), between(a.point, c.point));
    if (!(dot(normal, edge.side.outward()) > 0)) return;
    out_.hosts.push_back(edge.triangle);
    out_.triangles.push_back({vertex(a), vertex(b), vertex(c)});
  }

  std::uint32_t vertex(const Corner& corner) {
    const auto next = static_cast<std::uint32_t>(out_.points.size());
    const auto [found, is_new] = vertices_.try_emplace(corner.key(), next);
    if (is_new) {
      out_.points.push_back(corner.point);
      out_.normals.push_back(mesh_.normals[corner.like]);
      out_.colors.push_back(mesh_.colors[corner.like]);
      out_.materials.push_back(mesh_.materials[corner.like]);
    }
    return found->second;
  }

  const Surface& surface_;
  const Mesh& mesh_;
  const Curtain& curtain_;
  const std::vector<RimEdge> rim_;
  std::map<Key, Foot> feet_;
  std::map<std::tuple<int, std::uint32_t, bool>, std::uint32_t> vertices_;
  Skirts out_;
};

}  // namespace

Skirts hang(const Surface& surface, const Mesh& mesh, const Curtain& curtain) {
  return Hanger(surface, mesh, curtain).run();
}

}  // namespace hoodoo::surface
