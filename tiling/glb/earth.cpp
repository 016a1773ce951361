#include "tiling/glb/earth.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "engine/base/error.hpp"

namespace hoodoo::glb {
namespace {

using Steps = std::array<std::int64_t, 3>;

Vec3 metres(const Steps& origin, const std::array<std::int32_t, 3>& p, double step) {
  return {static_cast<double>(origin[0] + p[0]) * step,
          static_cast<double>(origin[1] + p[1]) * step,
          static_cast<double>(origin[2] + p[2]) * step};
}

Steps steps_of(const Vec3& p, double step) {
  Steps steps{};
  for (std::size_t a = 0; a < 3; ++a) {
    steps[a] = static_cast<std::int64_t>(std::floor(p[static_cast<int>(a)] / step + 0.5));
  }
  return steps;
}

std::array<std::int32_t, 3> from(const Steps& p, const Steps& origin) {
  return {static_cast<std::int32_t>(p[0] - origin[0]), static_cast<std::int32_t>(p[1] - origin[1]),
          static_cast<std::int32_t>(p[2] - origin[2])};
}

Vec3f unit(const Vec3& n) {
  const Vec3 u = normalized(n);
  return {static_cast<float>(u.x), static_cast<float>(u.y), static_cast<float>(u.z)};
}

/// The map carries planes by its cofactors.
Vec3f turned(const Vec3f& n, const std::array<Vec3, 3>& axes) {
  const auto& [a, b, c] = axes;
  return unit(cross(b, c) * static_cast<double>(n.x) + cross(c, a) * static_cast<double>(n.y) +
              cross(a, b) * static_cast<double>(n.z));
}
/// And back by its columns.
Vec3f turned_back(const Vec3f& n, const std::array<Vec3, 3>& axes) {
  const Vec3 v{static_cast<double>(n.x), static_cast<double>(n.y), static_cast<double>(n.z)};
  return unit({dot(axes[0], v), dot(axes[1], v), dot(axes[2], v)});
}

void lay(surface::Mesh& mesh, const Content& from_content, const Content& to,
         const dem::Earth& earth) {
  std::vector<Vec3> points;
  points.reserve(mesh.points.size());
  for (const auto& p : mesh.points) {
    points.push_back(metres(from_content.origin, p, from_content.step));
  }
  const auto places = earth.places(points);
  for (std::size_t i = 0; i < places.size(); ++i) {
    mesh.points[i] = from(steps_of(places[i].at, to.step), to.origin);
    mesh.normals[i] = turned(mesh.normals[i], places[i].axes);
  }
}

void lift(Decoded::Part& part, const Decoded& tile, const Decoded& to, const dem::Earth& earth,
          const std::string& where) {
  std::vector<Vec3> points;
  points.reserve(part.points.size());
  for (const auto& p : part.points) points.push_back(metres(tile.origin, p, tile.step));
  auto scene = earth.scene(points);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const auto steps = steps_of(scene[i], to.step);
    const Vec3 nearest = metres(steps, {}, to.step);
    if (length(scene[i] - nearest) > 0.4 * to.step) {
      throw Error(Fault::bad_input, where, "has a point that is none of its lattice");
    }
    part.points[i] = from(steps, to.origin);
    scene[i] = nearest;  // so that neighbours turn a normal by the same bits
  }
  const auto places = earth.places(scene);
  for (std::size_t i = 0; i < places.size(); ++i) {
    part.normals[i] = turned_back(part.normals[i], places[i].axes);
  }
}

}  // namespace

Content on_earth(const Content& content, const dem::Earth& earth) {
  Content laid = content;
  laid.step = content.step / finer;
  const Vec3 corner = metres(content.origin, {}, content.step);
  laid.origin = steps_of(earth.places({&corner, 1})[0].at, laid.step);
  lay(laid.surface, content, laid, earth);
  lay(laid.skirt, content, laid, earth);
  return laid;
}

Decoded from_earth(const Decoded& tile, const dem::Earth& earth, double step,
                   const std::string& where) {
  Decoded lifted = tile;
  lifted.step = step;
  const Vec3 corner = metres(tile.origin, {}, tile.step);
  lifted.origin = steps_of(earth.scene({&corner, 1})[0], step);
  lift(lifted.surface, tile, lifted, earth, where);
  lift(lifted.skirt, tile, lifted, earth, where);
  return lifted;
}

Box scene_box(const Box& box, const dem::Earth& earth) {
  constexpr double bent = 6e6;  // [m]
  std::array<Vec3, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = {i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                  i & 4 ? box.max.z : box.min.z};
  }
  Box all;
  for (const Vec3& corner : earth.scene(corners)) all.add(corner);
  const Vec3 size = box.max - box.min;
  return all.grown(dot(size, size) / bent);
}

}  // namespace hoodoo::glb
