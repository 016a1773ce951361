#include "engine/hydrology/accessibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hoodoo::hydrology {
namespace {

/// Central differences, one-sided beside what is missing; grid rows and columns count as x and y.
struct Slopes {
  double x, y;
};
Slopes slopes(const Grid& grid, std::int32_t i, std::int32_t j) {
  const auto row = static_cast<std::size_t>(j);
  const auto height = [&](std::int32_t a, std::int32_t b) {
    return grid.holds(a, b) && grid.valid(grid.index(a, b))
               ? static_cast<double>(grid.z[grid.index(a, b)])
               : std::numeric_limits<double>::quiet_NaN();
  };
  const double here = height(i, j);
  const auto across = [&](double before, double after, double step) {
    if (std::isnan(before) && std::isnan(after)) return 0.0;
    if (std::isnan(before)) return (after - here) / step;
    if (std::isnan(after)) return (here - before) / step;
    return (after - before) / (2 * step);
  };
  return {across(height(i - 1, j), height(i + 1, j), grid.dx[row]),
          across(height(i, j - 1), height(i, j + 1), grid.dy[row])};
}

/// The ball that touches the ground at a cell, and shrinks as it meets other cells.
class Ball {
 public:
  Ball(const Grid& grid, std::int32_t i, std::int32_t j, double most)
      : dx_(grid.dx[static_cast<std::size_t>(j)]),
        dy_(grid.dy[static_cast<std::size_t>(j)]),
        z_(static_cast<double>(grid.z[grid.index(i, j)])),
        radius_(most) {
    const auto [sx, sy] = slopes(grid, i, j);
    nz_ = 1 / std::sqrt(1 + sx * sx + sy * sy);
    nx_ = -sx * nz_, ny_ = -sy * nz_;
  }
  double radius() const { return radius_; }
  /// A point at distance d allows a ball of d / 2 at least, so rings end the search by themselves.
  bool reaches_ring(std::int32_t ring) const { return ring * std::min(dx_, dy_) < 2 * radius_; }

  void meet(std::int32_t a, std::int32_t b, float height) {
    const double x = a * dx_, y = b * dy_, h = static_cast<double>(height) - z_;
    const double ahead = nx_ * x + ny_ * y + nz_ * h;
    if (ahead > 0) radius_ = std::min(radius_, (x * x + y * y + h * h) / (2 * ahead));
  }
  /// Whether no cell with a1 <= a < a2, b1 <= b < b2 and at most this height can shrink it.
  bool clears(std::int32_t a1, std::int32_t a2, std::int32_t b1, std::int32_t b2,
              float highest) const {
    const double x1 = a1 * dx_, x2 = (a2 - 1) * dx_, y1 = b1 * dy_, y2 = (b2 - 1) * dy_;
    const double ahead = std::max(nx_ * x1, nx_ * x2) + std::max(ny_ * y1, ny_ * y2) +
                         nz_ * (static_cast<double>(highest) - z_);
    const double x = std::max({x1, -x2, 0.0}), y = std::max({y1, -y2, 0.0});
    constexpr double rounding = 1 + 1e-9;
    return ahead <= 0 || x * x + y * y >= 2 * ahead * radius_ * rounding;
  }

 private:
  double dx_, dy_, z_, nx_ = 0, ny_ = 0, nz_ = 0, radius_;
};

/// visit(a, b) for the cells of a square ring around (i, j) that lie in the raster.
template <class Visit>
void for_ring(const Grid& grid, std::int32_t i, std::int32_t j, std::int32_t ring, Visit visit) {
  for (std::int32_t b = -ring; b <= ring; ++b) {
    const bool edge = b == -ring || b == ring;
    for (std::int32_t a = -ring; a <= ring; a += edge ? 1 : 2 * ring) {
      if (grid.holds(i + a, j + b)) visit(a, b);
    }
  }
}

/// Balls of all cells: of blocks of cells the highest is known, and whole blocks that are too low
/// or too far are left out.
class Balls {
 public:
  Balls(const Grid& grid, double most) : grid_(grid), most_(most) {
    blocks_.push_back(highest(small));
    blocks_.push_back(highest(large));
  }

  double radius(std::int32_t i, std::int32_t j) const {
    if (!grid_.valid(grid_.index(i, j))) return std::numeric_limits<double>::quiet_NaN();
    Ball ball(grid_, i, j, most_);
    // Those beside it meet it first: what they leave is small on rough ground.
    std::int32_t ring = 1;
    for (; ring <= 2 && ball.reaches_ring(ring); ++ring) {
      for_ring(grid_, i, j, ring, [&](std::int32_t a, std::int32_t b) {
        const float z = grid_.z[grid_.index(i + a, j + b)];
        if (!std::isnan(z)) ball.meet(a, b, z);
      });
    }
    if (ball.reaches_ring(ring)) meet_blocks(ball, i, j);
    return ball.radius();
  }

 private:
  static constexpr std::int32_t small = 4, large = 16;
  struct Highest {
    std::int32_t across;
    std::vector<float> z;
  };

  Highest highest(std::int32_t side) const {
    Highest blocks{(grid_.width + side - 1) / side, {}};
    const std::int32_t down = (grid_.height + side - 1) / side;
    blocks.z.assign(static_cast<std::size_t>(blocks.across) * static_cast<std::size_t>(down),
                    -std::numeric_limits<float>::infinity());
    for (std::int32_t j = 0; j < grid_.height; ++j) {
      for (std::int32_t i = 0; i < grid_.width; ++i) {
        auto& z = blocks.z[static_cast<std::size_t>(j / side * blocks.across + i / side)];
        z = std::max(z, grid_.z[grid_.index(i, j)]);  // its first argument where the other is NaN
      }
    }
    return blocks;
  }

  void meet_blocks(Ball& ball, std::int32_t i, std::int32_t j) const {
    std::int32_t reach = 1;
    while (ball.reaches_ring(reach)) reach *= 2;
    for (std::int32_t low = reach / 2; low + 1 < reach;) {
      const std::int32_t middle = low + (reach - low) / 2;
      (ball.reaches_ring(middle) ? low : reach) = middle;
    }
    const std::int32_t top = std::max(j - reach, 0) / large, left = std::max(i - reach, 0) / large;
    const std::int32_t bottom = std::min(j + reach, grid_.height - 1) / large;
    const std::int32_t right = std::min(i + reach, grid_.width - 1) / large;
    for (std::int32_t v = top; v <= bottom; ++v) {
      for (std::int32_t u = left; u <= right; ++u) meet_block(ball, i, j, {u, v}, 1);
    }
  }

  struct Block {
    std::int32_t u, v;
  };
  void meet_block(Ball& ball, std::int32_t i, std::int32_t j, Block block, std::size_t size) const {
    const std::int32_t side = size == 0 ? small : large;
    const std::int32_t i1 = block.u * side, i2 = std::min(i1 + side, grid_.width);
    const std::int32_t j1 = block.v * side, j2 = std::min(j1 + side, grid_.height);
    const auto& z = blocks_[size];
    if (i1 >= i2 || j1 >= j2) return;
    if (ball.clears(i1 - i, i2 - i, j1 - j, j2 - j,
                    z.z[static_cast<std::size_t>(block.v * z.across + block.u)])) {
      return;
    }
    if (size > 0) {
      constexpr std::int32_t parts = large / small;
      for (std::int32_t n = 0; n < parts * parts; ++n) {
        meet_block(ball, i, j, {block.u * parts + n % parts, block.v * parts + n / parts}, 0);
      }
      return;
    }
    for (std::int32_t b = j1; b < j2; ++b) {
      for (std::int32_t a = i1; a < i2; ++a) {
        const float height = grid_.z[grid_.index(a, b)];
        if (!std::isnan(height)) ball.meet(a - i, b - j, height);
      }
    }
  }

  const Grid& grid_;
  double most_;
  std::vector<Highest> blocks_;  // small ones, large ones
};

}  // namespace

double tangent_ball(const Grid& grid, std::int32_t i, std::int32_t j, double most) {
  if (!grid.valid(grid.index(i, j))) return std::numeric_limits<double>::quiet_NaN();
  Ball ball(grid, i, j, most);
  for (std::int32_t ring = 1; ball.reaches_ring(ring); ++ring) {
    for_ring(grid, i, j, ring, [&](std::int32_t a, std::int32_t b) {
      const float z = grid.z[grid.index(i + a, j + b)];
      if (!std::isnan(z)) ball.meet(a, b, z);
    });
  }
  return ball.radius();
}

std::vector<float> accessibility(const Grid& grid, double most, Rows rows) {
  const Balls balls(grid, most);
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(rows.to - rows.from) *
                 static_cast<std::size_t>(grid.width));
  for (std::int32_t j = rows.from; j < rows.to; ++j) {
    for (std::int32_t i = 0; i < grid.width; ++i) {
      values.push_back(static_cast<float>(balls.radius(i, j) / most));
    }
  }
  return values;
}

std::int32_t accessibility_reach(const Grid& grid, double most) {
  double least = std::numeric_limits<double>::infinity();
  for (const double d : grid.dx) least = std::min(least, d);
  for (const double d : grid.dy) least = std::min(least, d);
  return static_cast<std::int32_t>(std::min(2 * most / least, 1e9)) + 1;
}

}  // namespace hoodoo::hydrology
