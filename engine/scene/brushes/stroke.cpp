#include "engine/scene/brushes/stroke.hpp"

#include <algorithm>
#include <cmath>

namespace hoodoo::scene {
namespace {

/// Lines of one polyline node: short enough that most blocks see one or two nodes of a long tube.
constexpr std::size_t lines_per_node = 16;

tree::Node united(std::vector<tree::Node> parts) {
  if (parts.size() == 1) return std::move(parts.front());
  return {tree::Union{}, std::move(parts)};
}

}  // namespace

std::vector<Vec3> smooth_curve(const std::vector<Vec3>& points, double radius) {
  if (points.size() < 3) return points;
  const auto last = points.size() - 1;
  std::vector<Vec3> chain = {points[0]};
  for (std::size_t i = 0; i < last; ++i) {
    const Vec3 &b = points[i], &c = points[i + 1];
    const Vec3 a = i > 0 ? points[i - 1] : b - (c - b);
    const Vec3 d = i + 1 < last ? points[i + 2] : c + (c - b);
    const int lines = static_cast<int>(std::clamp(std::ceil(length(c - b) / radius), 1.0, 16.0));
    for (int k = 1; k < lines; ++k) {
      const double t = static_cast<double>(k) / lines;
      chain.push_back(b +
                      ((c - a) + ((a * 2 - b * 5 + c * 4 - d) + (b * 3 - a - c * 3 + d) * t) * t) *
                          (t * 0.5));
    }
    chain.push_back(c);
  }
  return chain;
}

tree::Node tube(const std::vector<Vec3>& chain, double radius,
                const tree::StarTurbulence& turbulence) {
  std::vector<tree::Node> parts;
  for (std::size_t i = 0; i + 1 < chain.size(); i += lines_per_node) {
    const auto end = std::min(i + lines_per_node + 1, chain.size());
    tree::Polyline part;
    for (std::size_t k = i; k < end; ++k) part.points.emplace_back(chain[k]);
    part.radius = radius;
    part.turbulence = turbulence;
    parts.push_back({std::move(part), {}});
  }
  return united(std::move(parts));
}

tree::Node tube(const std::vector<Bead>& chain, const tree::StarTurbulence& turbulence) {
  std::vector<tree::Node> parts;
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    tree::Segment part;
    part.from = chain[i].at;
    part.to = chain[i + 1].at;
    part.radius = (chain[i].radius + chain[i + 1].radius) / 2;
    part.turbulence = turbulence;
    parts.push_back({part, {}});
  }
  return united(std::move(parts));
}

void check_tube(double radius, const tree::StarTurbulence& turbulence, const std::string& where,
                std::vector<Problem>& problems) {
  tree::Thin thin;
  thin.radius = radius;
  thin.turbulence = turbulence;
  thin.check(where, problems);
}

std::vector<Vec3> places(const std::vector<tree::Point>& points) {
  std::vector<Vec3> list;
  list.reserve(points.size());
  for (const auto& point : points) list.push_back(point.value);
  return list;
}

}  // namespace hoodoo::scene
