#pragma once
#include <cmath>
#include <vector>

#include "engine/tree/ball_set.hpp"
#include "engine/tree/evaluate.hpp"
#include "engine/tree/splat.hpp"

namespace hoodoo::tree {

/// Field of many balls, splatted.
class BallKernel final : public Kernel {
 public:
  BallKernel(std::string_view type, const SplatRule& rule, std::vector<SplatBall> balls)
      : type_(type), rule_(rule), balls_(std::move(balls)) {}

  void values(const Points& at, std::span<float> out) const override {
    splat(balls_, rule_, at, out);
  }
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    splat(balls_, rule_, at, out, g);
  }
  void cube(const Cube& at, CubeValues out, AskedRows& asked) const override {
    splat(balls_, rule_, at, out, asked);
  }
  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(std::string(static_cast<std::size_t>(2 * depth), ' ') + std::string(type_));
  }

 private:
  std::string_view type_;
  SplatRule rule_;
  SplatBalls balls_;
};

/// The farthest that a side of `box` lies from `origin` along an axis, infinite ones left out [m].
inline double farthest_side(const Box& box, const Vec3& origin) {
  double most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {box.min[axis], box.max[axis]}) {
      if (std::isfinite(side)) most = std::max(most, std::abs(side - origin[axis]));
    }
  }
  return most;
}

/// The balls whose field can differ from 0 in single precision at points of `box` relative to
/// `origin`, in their order.
template <Swarm N>
std::vector<Balls::Found> balls_near(const N& node, const Box& box, const Vec3& origin) {
  return node.balls.near(box, node.stretch() * (1 + 5e-5),
                         node.margin() * (1 + 5e-5) + 4e-6 * farthest_side(box, origin));
}

/// The node with those of its balls in memory that `balls_near` of the same box and origin finds
/// and whose radius is at least `least`.
template <Swarm N>
N held_near(const N& node, const Box& box, const Vec3& origin, double least = 0) {
  N held = node;
  if (node.balls.in_file()) {
    held.balls =
        node.balls.part(box, node.stretch() * (1 + 5e-5),
                        node.margin() * (1 + 5e-5) + 4e-6 * farthest_side(box, origin), least);
  }
  return held;
}

/// How far roughness moves a ball's boundary [m] where the points of a box see it.
template <Swarm N>
Interval bump_bounds(const N& node, const Balls::Stored& ball, const Box& box) {
  const double a = node.turbulence.amplitude;
  const Turbulence noise = node.turbulence.noise();
  const Vec3 half = (box.max - box.min) * 0.5;
  if (a == 0 || turbulence_slope(noise) * length(half) > 1) return {-a, a};
  const Vec3 place = (box.min + box.max) * 0.5 - Vec3{ball.x, ball.y, ball.z};
  Uncertain::was_undecided();
  const auto p = star_projection(Uncertain(place.x - half.x, place.x + half.x),
                                 Uncertain(place.y - half.y, place.y + half.y),
                                 Uncertain(place.z - half.z, place.z + half.z), Uncertain(0),
                                 Uncertain(0), Uncertain(0), ball.radius);
  if (Uncertain::was_undecided()) return {-a, a};
  const Vec3 middle{ball.x + p.x.middle(), ball.y + p.y.middle(), ball.z + p.z.middle()};
  const double around = length(Vec3{p.x.half(), p.y.half(), p.z.half()});
  return (turbulence_bounds(noise, middle, around) * 2 - Interval{1, 1}) * a;
}

/// Bounds of one ball's field, its distance off by at most `rounding` [m], its boundary by `bump`.
template <Swarm N>
Interval ball_bounds(const N& node, const Balls::Found& found, double rounding,
                     const Interval& bump) {
  const double least = found.near - rounding, most = found.far + rounding;
  const double reach = node.reach(found.ball->radius);
  const auto g = [](double u) {
    const double q = std::max(0.0, 1 - u * u);
    return q * q * q;
  };
  double near = 0, far = 0;  // in units of the reach
  if constexpr (N::thin) {
    near = std::max(0.0, least) / (reach + bump.high);
    far = most / (reach + bump.low);
  } else {
    const double inset = half_falloff * reach - found.ball->radius;
    near = std::max(0.0, least - bump.high + inset) / reach;
    far = std::max(0.0, most - bump.low + inset) / reach;
  }
  return Interval{g(far), g(near)} * static_cast<double>(found.ball->energy);
}

template <Swarm N>
SplatBall splat_ball(const N& node, const Balls::Stored& ball, const Vec3& origin) {
  const double reach = node.reach(ball.radius);
  return {static_cast<float>(ball.x - origin.x),
          static_cast<float>(ball.y - origin.y),
          static_cast<float>(ball.z - origin.z),
          static_cast<float>(ball.radius),
          static_cast<float>(reach),
          static_cast<float>(inverse_square(reach)),
          ball.energy};
}

template <Swarm N>
Compiled compile_swarm(const N& node, const Block& block) {
  if (node.balls.in_file()) {
    return compile_swarm(held_near(node, block.box, block.origin), block);
  }
  const auto found = balls_near(node, block.box, block.origin);
  if (found.empty()) return {};
  std::vector<SplatBall> balls;
  balls.reserve(found.size());
  Interval bounds{0, 0};
  double slack = 0;
  const double side = farthest_side(block.box, block.origin);
  for (const Balls::Found& f : found) {
    balls.push_back(splat_ball(node, *f.ball, block.origin));
    const double rounding = 4e-6 * (side + f.far);
    const Interval bump = bump_bounds(node, *f.ball, block.box.grown(2 * rounding));
    bounds = bounds + ball_bounds(node, f, rounding, bump);
    slack += std::abs(static_cast<double>(f.ball->energy));
  }
  // Each ball's place and field round, and so does each partial sum.
  slack *= 1e-5 + 1e-7 * static_cast<double>(found.size());
  bounds = {bounds.low - slack, bounds.high + slack};
  SplatRule rule{N::thin, 0, static_cast<float>(node.turbulence.amplitude), {}};
  if constexpr (!N::thin) rule.inset = static_cast<float>(half_falloff * node.falloff);
  if (node.turbulence.amplitude > 0) rule.noise = placed(node.turbulence.noise(), block.origin);
  return {std::make_unique<BallKernel>(N::type, rule, std::move(balls)), bounds};
}

}  // namespace hoodoo::tree
