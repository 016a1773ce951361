#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tiling/surface/mesh.hpp"

namespace hoodoo::surface {
namespace {

constexpr double near_enough = 0.01;  // of a cell: about what snapping costs
constexpr int most_steps = 3;

/// A vertex on its way.
struct Traveller {
  std::size_t vertex;
  Vec3 step;  // Newton's, in steps of the lattice
};

class Settling {
 public:
  Settling(slice::Land& land, const volume::Index& low, std::span<Point> points)
      : land_(land), units_(land.slice().lattice.units()), points_(points) {
    for (std::size_t a = 0; a < 3; ++a) origin_[a] = low[a] * units_;
  }

  void run() {
    auto travellers = those_off_the_surface();
    for (int i = 0; i < most_steps && !travellers.empty(); ++i) advance(travellers);
  }

 private:
  Point cell_of(const Point& p) const { return {p[0] / units_, p[1] / units_, p[2] / units_}; }

  /// Two sheets of one cell keep their places: they must not meet.
  bool is_alone(std::size_t i) const {
    const Point cell = cell_of(points_[i]);
    return !(i > 0 && cell_of(points_[i - 1]) == cell) &&
           !(i + 1 < points_.size() && cell_of(points_[i + 1]) == cell);
  }

  std::vector<Vec3> newton(std::span<const Point> at) const {
    std::vector<slice::StepPoint> points(at.size());
    for (std::size_t i = 0; i < at.size(); ++i) {
      for (std::size_t a = 0; a < 3; ++a) points[i][a] = origin_[a] + at[i][a];
    }
    auto steps = land_.steps_to_surface(points);
    for (auto& step : steps) step = step * (1 / land_.slice().step());
    return steps;
  }

  std::vector<Traveller> those_off_the_surface() const {
    const auto steps = newton(points_);
    std::vector<Traveller> off;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (length(steps[i]) > near_enough * units_ && is_alone(i)) off.push_back({i, steps[i]});
    }
    return off;
  }

  /// Where the step leads, one step inside the vertex's own cell.
  Point reached(const Traveller& traveller) const {
    Point p = points_[traveller.vertex];
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int32_t low = p[a] / units_ * units_;
      const double to = std::floor(p[a] + traveller.step[static_cast<int>(a)] + 0.5);
      p[a] = static_cast<std::int32_t>(std::clamp(to, low + 1.0, low + units_ - 1.0));
    }
    return p;
  }

  /// Takes one step each; those that it brought nearer and not near enough travel on.
  void advance(std::vector<Traveller>& travellers) {
    std::vector<Point> to(travellers.size());
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = reached(travellers[i]);
    const auto steps = newton(to);
    std::vector<Traveller> on;
    for (std::size_t i = 0; i < to.size(); ++i) {
      if (!(length(steps[i]) < length(travellers[i].step))) continue;
      points_[travellers[i].vertex] = to[i];
      if (length(steps[i]) > near_enough * units_) on.push_back({travellers[i].vertex, steps[i]});
    }
    travellers = std::move(on);
  }

  slice::Land& land_;
  int units_;
  std::span<Point> points_;
  slice::StepPoint origin_{};
};

}  // namespace

Surface extract(const volume::Volume& volume, slice::Land& land) {
  return polygonize(volume, land.slice().lattice.units(),
                    [&](std::span<Point> points) { Settling(land, volume.low(), points).run(); });
}

}  // namespace hoodoo::surface
