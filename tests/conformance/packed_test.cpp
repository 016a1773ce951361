// Packed unions against the unions they stand for.
#include <gtest/gtest.h>

#include <bit>
#include <nlohmann/json.hpp>

#include "engine/tree/evaluate.hpp"
#include "engine/tree/pack.hpp"
#include "engine/tree/reach.hpp"
#include "tests/conformance/random_tree.hpp"

namespace hoodoo::tree::conformance {
namespace {

/// A union of 80 random trees that have a packed form.
Node random_union(Random& random, int depth) {
  Node many{Union{}, {}};
  while (many.children.size() < 80) {
    Node tree = random_tree(random, Family::terrain, depth);
    if (PackedTrees::of({tree})) many.children.push_back(std::move(tree));
  }
  return many;
}

bool is_packed(const Node& tree) { return !std::get<Union>(tree.value).packed.empty(); }

std::vector<float> values(const Node& tree, const Block& block, const Points& at) {
  std::vector<float> f(at.size());
  const Compiled compiled = compile(tree, block);
  if (compiled.kernel) compiled.kernel->values(at, f);
  for (float& v : f) v += 0.0F;
  return f;
}

TEST(PackedUnion, HasTheBitsOfTheUnionItStandsFor) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Node many = random_union(random, static_cast<int>(seed % 4));
    const Node packed = pack_unions(many);
    ASSERT_TRUE(is_packed(packed));
    EXPECT_TRUE(packed.children.empty());
    EXPECT_EQ(count(packed), count(many));
    EXPECT_EQ(support(packed).influence, support(many).influence);
    EXPECT_EQ(support(packed).range, support(many).range);
    EXPECT_EQ(support(packed).slope, support(many).slope);
    EXPECT_EQ(to_json(packed), to_json(many));
    for (int i = 0; i < 4; ++i) {
      const Block block = random_block(random, 20);
      const Cloud cloud(random, block, batch_size);
      const auto expected = values(many, block, cloud.points());
      EXPECT_EQ(values(packed, block, cloud.points()), expected);
      EXPECT_EQ(values(prune(packed, block.box, 0), block, cloud.points()), expected);
      const auto reach = reach_over(packed, block.box).z, other = reach_over(many, block.box).z;
      EXPECT_EQ(reach, other);
    }
  }
}

TEST(PackedUnion, IsPrunedAsIfItWereNot) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Node many = random_union(random, 0), packed = pack_unions(many);
    const Box reach = random_block(random, 12).box;
    for (const double thinnest : {0.0, 6.0}) {
      EXPECT_EQ(prune(packed, reach, thinnest), prune(many, reach, thinnest));
    }
  }
}

TEST(PackedUnion, IsEqualToItselfAlone) {
  Random random(3);
  const Node one = random_union(random, 0), other = random_union(random, 0);
  EXPECT_EQ(pack_unions(one), pack_unions(one));
  EXPECT_NE(pack_unions(one), pack_unions(other));
}

TEST(PackedUnion, TakesAThirdOfTheMemory) {
  Node many{Union{}, {}};
  for (int body = 0; body < 100; ++body) {
    SmoothUnion join;
    join.width = 0.3;
    Node one{join, {}};
    for (int i = 0; i < 30; ++i) {
      Sphere s;
      s.center = Vec3{body + 0.1, 0.3, i / 3.0};
      s.radius = 1 + 0.01 * i;
      s.falloff = 0.7 + 0.01 * i;
      s.turbulence.amplitude = 0.1 + 0.001 * i;
      s.turbulence.wavelength = 1.3 + 0.01 * i;
      s.turbulence.octaves = 4;
      one.children.push_back({s, {}});
    }
    many.children.push_back(std::move(one));
  }
  const Node packed = pack_unions(many);
  ASSERT_TRUE(is_packed(packed));
  EXPECT_LE(memory(packed), 66 * count(packed));
  EXPECT_LE(3 * memory(packed), memory(many));
}

TEST(PackedUnion, LeavesWhatHasNoPackedForm) {
  Random random(5);
  Node many = random_union(random, 0);
  Expression formula;
  formula.formula = "x / 10";
  many.children.push_back({formula, {}});
  EXPECT_FALSE(is_packed(pack_unions(many)));
  EXPECT_EQ(pack_unions(many), many);
  const Node few{Union{}, {many.children.begin(), many.children.begin() + 63}};
  EXPECT_FALSE(is_packed(pack_unions(few)));
}

}  // namespace
}  // namespace hoodoo::tree::conformance
