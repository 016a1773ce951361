#include "engine/generator/erosion.hpp"

#include <utility>
#include <vector>

#include "engine/tree/balls.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::generator {

void erode(const Erosion& erosion, std::span<const Stressed> samples, Growth& growth) {
  std::vector<tree::Ball> balls;
  auto& marks = growth.record.list("samples");
  for (const auto& [sample, stress] : samples) {
    const auto rho = static_cast<double>(sample.resistance);
    const double effect = erosion_effect(rho, stress, erosion.beta) * growth.weight(sample.at);
    marks.push_back({sample.at, effect});
    if (effect <= 0 || effect < erosion.threshold) continue;
    balls.push_back({sample.at, erosion.radius, static_cast<float>(erosion.energy * effect)});
  }
  growth.record.count("sampled", samples.size());
  growth.record.count("too weak", samples.size() - balls.size());
  growth.record.count("placed", balls.size());
  expect_few(balls.size(), most_primitives, "balls");
  if (balls.empty()) return;
  tree::PointSet set;
  set.balls = tree::Balls(balls);
  growth.add(tree::Operation::carve, {std::move(set), {}});
}

}  // namespace hoodoo::generator
