#include "tests/bench/engine.hpp"

#include <utility>

namespace hoodoo::bench {
namespace {

tree::StarTurbulence turbulence_of(const Rough& rough) {
  const Turbulence& t = rough.turbulence;
  return {static_cast<double>(rough.amplitude), t.wavelength, t.octaves, t.seed};
}

Vec3 centre(const Ball& b) {
  return {static_cast<double>(b.x), static_cast<double>(b.y), static_cast<double>(b.z)};
}

double radius(const Ball& b) { return static_cast<double>(b.reach) * tree::half_falloff; }

}  // namespace

tree::Node list_of(const std::vector<Ball>& balls, const Rough& rough) {
  std::vector<tree::Ball> list;
  for (const Ball& b : balls) list.push_back({centre(b), radius(b), b.energy});
  tree::PointSet set;
  set.balls = tree::Balls(list);
  set.turbulence = turbulence_of(rough);
  return {set, {}};
}

tree::Node blend_of(const std::vector<Ball>& balls) {
  tree::Node blend{tree::Blend{}, {}};
  for (const Ball& b : balls) {
    tree::PointNode p;
    p.center = centre(b);
    p.radius = radius(b);
    p.energy = static_cast<double>(b.energy);
    blend.children.push_back({p, {}});
  }
  return blend;
}

tree::Ground ground_of(tree::Node balls) {
  tree::HeightBody land;
  land.id = "land";
  land.falloff = static_cast<double>(ground_falloff);
  tree::Ground ground;
  ground.bodies.push_back(land);
  ground.steps.push_back({"balls", "", tree::Operation::blend, std::move(balls), nullptr, -1});
  ground.materials.push_back({"rock", {}, 0, 1, 0});
  return ground;
}

Engine::Engine(const Scene& scene, tree::Node balls)
    : scene_(scene), ground_(ground_of(std::move(balls))) {
  for (int i = 0; i < side; ++i) axis_.push_back(static_cast<float>(i));
  for (int n = 0; n < points_per_block; ++n) {
    x_.push_back(static_cast<float>(n / (side * side)));
    y_.push_back(static_cast<float>(n / side % side));
    z_.push_back(static_cast<float>(n % side));
  }
}

std::unique_ptr<const tree::Field> Engine::field(const BlockCorner& b) const {
  const Vec3 origin{static_cast<double>(b[0]), static_cast<double>(b[1]),
                    static_cast<double>(b[2])};
  return tree::compile(ground_, {&scene_.window, 1}, origin,
                       {origin, origin + Vec3{side, side, side}});
}

void Engine::prune() {
  const double low = scene_.low - side, high = scene_.low + scene_.wide + side;
  ground_ = tree::prune(ground_, {{low, low, -1000}, {high, high, 1000}}, 0);
}

void Engine::values(std::span<const BlockCorner> blocks, std::span<float> out) const {
  tree::Columns columns;
  const BlockCorner* last = nullptr;
  for (const BlockCorner& b : blocks) {
    if (last == nullptr || b[0] != (*last)[0] || b[1] != (*last)[1]) columns.clear();
    last = &b;
    field(b)->grid({axis_, axis_, axis_}, out, &columns);
  }
}

}  // namespace hoodoo::bench
