#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "tiling/surface/mesh.hpp"

namespace hoodoo::surface {
namespace {

constexpr double near_enough = 0.01;  // of a cell: about what snapping costs
constexpr int most_steps = 3;
constexpr std::size_t batch = 2048;  // vertices whose steps stay in the cache

/// A vertex on its way.
struct Traveller {
  std::size_t vertex;
  Point cell;  // its low corner, in steps of the lattice
  Vec3 step;   // Newton's, in steps of the lattice
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
  /// The low corner of the cell that holds p.
  Point cell_of(const Point& p) const {
    return {p[0] / units_ * units_, p[1] / units_ * units_, p[2] / units_ * units_};
  }
  bool holds(const Point& cell, const Point& p) const {
    const auto inside = [&](std::size_t a) { return p[a] >= cell[a] && p[a] - cell[a] < units_; };
    return inside(0) && inside(1) && inside(2);
  }

  /// Two sheets of one cell keep their places: they must not meet.
  bool is_alone(std::size_t i, const Point& cell) const {
    return !(i > 0 && holds(cell, points_[i - 1])) &&
           !(i + 1 < points_.size() && holds(cell, points_[i + 1]));
  }

  /// Their Newton's steps, in steps of the lattice.
  void newton(std::span<const Point> at) {
    land_.steps_to_surface(origin_, at, moves_);
    const double per_step = 1 / land_.slice().step();
    squares_.resize(at.size());
    for (std::size_t i = 0; i < at.size(); ++i) {
      double &x = moves_.x[i], &y = moves_.y[i], &z = moves_.z[i];
      x *= per_step, y *= per_step, z *= per_step;
      squares_[i] = x * x + y * y + z * z;
    }
  }
  double length_of(std::size_t i) const { return std::sqrt(squares_[i]); }
  /// The vertex is not near enough. Most are: a root is not taken of what is surely too small.
  bool is_off(std::size_t i) const {
    const double least = near_enough * units_;
    return squares_[i] > 0.99 * least * least && length_of(i) > least;
  }
  Vec3 move(std::size_t i) const { return {moves_.x[i], moves_.y[i], moves_.z[i]}; }

  std::vector<Traveller> those_off_the_surface() {
    std::vector<Traveller> off;
    for (std::size_t from = 0; from < points_.size(); from += batch) {
      const auto some = points_.subspan(from, std::min(batch, points_.size() - from));
      newton(some);
      for (std::size_t i = 0; i < some.size(); ++i) {
        if (!is_off(i)) continue;
        const Point cell = cell_of(some[i]);
        if (is_alone(from + i, cell)) off.push_back({from + i, cell, move(i)});
      }
    }
    return off;
  }

  /// Where the step leads, one step inside the vertex's own cell.
  Point reached(const Traveller& traveller) const {
    Point p = points_[traveller.vertex];
    for (std::size_t a = 0; a < 3; ++a) {
      const double low = traveller.cell[a];
      const double to = p[a] + traveller.step[static_cast<int>(a)] + 0.5;
      // Whole numbers on both sides, and none is below 0: what is cut off is what floor takes.
      p[a] = static_cast<std::int32_t>(std::clamp(to, low + 1, low + units_ - 1));
    }
    return p;
  }

  /// Takes one step each; those that it brought nearer and not near enough travel on.
  void advance(std::vector<Traveller>& travellers) {
    std::vector<Point> to(travellers.size());
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = reached(travellers[i]);
    newton(to);
    std::vector<Traveller> on;
    for (std::size_t i = 0; i < to.size(); ++i) {
      if (!(length_of(i) < length(travellers[i].step))) continue;
      points_[travellers[i].vertex] = to[i];
      if (is_off(i)) on.push_back({travellers[i].vertex, travellers[i].cell, move(i)});
    }
    travellers = std::move(on);
  }

  slice::Land& land_;
  int units_;
  std::span<Point> points_;
  slice::StepPoint origin_{};
  slice::Land::Moves moves_;
  std::vector<double> squares_;  // of the moves
};

}  // namespace

Surface extract(const volume::Volume& volume, slice::Land& land) {
  Workspace workspace;
  extract(volume, land, workspace);
  return std::move(workspace.surface);
}

const Surface& extract(const volume::Volume& volume, slice::Land& land, Workspace& workspace) {
  return polygonize(volume, land.slice().lattice.units(), workspace,
                    [&](std::span<Point> points) { Settling(land, volume.low(), points).run(); });
}

}  // namespace hoodoo::surface
