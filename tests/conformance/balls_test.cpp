// Lists of balls against blends of the nodes they stand for.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <bit>

#include "engine/tree/evaluate.hpp"
#include "tests/conformance/random_tree.hpp"

namespace hoodoo::tree::conformance {
namespace {

Node single(const PointSet& set, const Ball& ball) {
  PointNode p;
  p.center = ball.center;
  p.radius = ball.radius;
  p.energy = static_cast<double>(ball.energy);
  p.turbulence = set.turbulence;
  return {p, {}};
}
Node single(const SphereSet& set, const Ball& ball) {
  Sphere s;
  s.center = ball.center;
  s.radius = ball.radius;
  s.falloff = set.falloff;
  s.energy = static_cast<double>(ball.energy);
  s.turbulence = set.turbulence;
  return {s, {}};
}

struct Slopes {
  std::vector<float> f, x, y, z;
};
Slopes slopes(const Node& tree, const Block& block, const Points& at) {
  const std::size_t n = at.size();
  Slopes s{std::vector<float>(n), std::vector<float>(n), std::vector<float>(n),
           std::vector<float>(n)};
  const Compiled compiled = compile(tree, block);
  if (compiled.kernel) compiled.kernel->gradients(at, s.f, {s.x, s.y, s.z});
  for (float& v : s.f) v += 0.0F;
  return s;
}

template <class N>
class ListOfBalls : public testing::Test {};
using Lists = testing::Types<PointSet, SphereSet>;
TYPED_TEST_SUITE(ListOfBalls, Lists);

TYPED_TEST(ListOfBalls, HasTheBitsOfABlendOfItsBalls) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Node list = random_node<TypeParam>(random, Family::terrain, 0);
    const auto& set = std::get<TypeParam>(list.value);
    Node blend{Blend{}, {}};
    for (const Ball& b : set.balls.list()) blend.children.push_back(single(set, b));
    const Block block = random_block(random, 20);
    const Cloud cloud(random, block, batch_size);
    const Slopes one = slopes(list, block, cloud.points());
    const Slopes other = slopes(blend, block, cloud.points());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      ASSERT_EQ(std::bit_cast<std::uint32_t>(one.f[i]), std::bit_cast<std::uint32_t>(other.f[i]));
      const float steep = std::abs(other.x[i]) + std::abs(other.y[i]) + std::abs(other.z[i]);
      ASSERT_NEAR(one.x[i], other.x[i], 1e-4F * (steep + 1));
      ASSERT_NEAR(one.y[i], other.y[i], 1e-4F * (steep + 1));
      ASSERT_NEAR(one.z[i], other.z[i], 1e-4F * (steep + 1));
    }
  }
}

TYPED_TEST(ListOfBalls, IsPrunedToTheBallsThatReachABox) {
  Random random(1);
  std::vector<Ball> balls;
  for (int i = 0; i < 5000; ++i) balls.push_back({random.place(200), random.real(0.5, 3), 1});
  TypeParam set;
  set.balls = Balls(balls);
  EXPECT_EQ(set.balls.list(), balls);
  const Node list{set, {}};
  EXPECT_EQ(count(list), 5001u);
  const Box reach{{-20, -20, -20}, {20, 20, 20}};
  const Node pruned = prune(list, reach, 0);
  EXPECT_LT(count(pruned), 200u);
  const Node thick = prune(list, reach, 4);
  EXPECT_LT(count(thick), count(pruned));
  for (const Ball& b : std::get<TypeParam>(thick.value).balls.list()) EXPECT_GE(b.radius, 2);
}

}  // namespace
}  // namespace hoodoo::tree::conformance
