// Every node type against every claim of node_type.hpp. A type added to the variant is tested
// without another line here.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <bit>
#include <cmath>
#include <sstream>
#include <type_traits>
#include <variant>

#include "engine/tree/evaluate.hpp"
#include "tests/conformance/random_tree.hpp"

namespace hoodoo::tree::conformance {
namespace {

constexpr int trees_per_node = 100;
constexpr std::size_t points_per_tree = 200;

struct Evaluated {
  std::vector<float> f, x, y, z;
};

/// -0 is taken as 0, as tree::Field gives them.
std::vector<float> values(const Compiled& tree, const Points& at) {
  std::vector<float> out(at.size(), 0.0F);
  for (std::size_t i = 0; i < at.size(); i += batch_size) {
    const std::size_t n = std::min(batch_size, at.size() - i);
    const Points batch{at.x.subspan(i, n), at.y.subspan(i, n), at.z.subspan(i, n)};
    if (tree.kernel) tree.kernel->values(batch, {out.data() + i, n});
  }
  for (float& v : out) v += 0.0F;
  return out;
}

/// Of at most batch_size points.
Evaluated gradients(const Compiled& tree, const Points& at) {
  const std::size_t n = at.size();
  Evaluated e{std::vector<float>(n), std::vector<float>(n), std::vector<float>(n),
              std::vector<float>(n)};
  if (tree.kernel) tree.kernel->gradients(at, e.f, {e.x, e.y, e.z});
  for (auto* row : {&e.f, &e.x, &e.y, &e.z}) {
    for (float& v : *row) v += 0.0F;
  }
  return e;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float p, float q) {
    return std::bit_cast<std::uint32_t>(p) == std::bit_cast<std::uint32_t>(q);
  });
}

class EveryNode : public testing::TestWithParam<NodeKind> {
 protected:
  /// Calls `check(tree, random)` for many random trees whose root is of the type.
  template <class Check>
  void for_trees(std::uint64_t salt, Check check) {
    for (int i = 0; i < trees_per_node; ++i) {
      const auto seed = salt * 1000 + static_cast<std::uint64_t>(i);
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      seed_ = seed;
      Random random(seed);
      const Family family = GetParam().family == Family::any ? Family::terrain : GetParam().family;
      Node tree = GetParam().make(random, family, 2);
      // A distance is tried as the field it makes.
      if (family == Family::distance) {
        FromDistance field;
        field.falloff = random.real(2, 12);
        tree = {field, {std::move(tree)}};
      }
      check(tree, random);
      if (HasFailure()) return;
    }
  }
  std::uint64_t seed() const { return seed_; }

 private:
  std::uint64_t seed_ = 0;
};

TEST_P(EveryNode, GivesABatchTheBitsOfSinglePoints) {
  for_trees(1, [](const Node& tree, Random& random) {
    const Block block = random_block(random, 30);
    const Compiled compiled = compile(tree, block);
    const Cloud cloud(random, block, points_per_tree);
    const auto together = values(compiled, cloud.points());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Points one{{&cloud.x[i], 1}, {&cloud.y[i], 1}, {&cloud.z[i], 1}};
      ASSERT_TRUE(same_bits(values(compiled, one), {together[i]}));
    }
  });
}

TEST_P(EveryNode, GivesTheSameValuesWithAndWithoutGradients) {
  for_trees(2, [](const Node& tree, Random& random) {
    const Block block = random_block(random, 30);
    const Compiled compiled = compile(tree, block);
    const Cloud cloud(random, block, points_per_tree);
    ASSERT_TRUE(same_bits(values(compiled, cloud.points()), gradients(compiled, cloud.points()).f));
  });
}

/// Of a whole cube of points, on every instruction set.
TEST_P(EveryNode, GivesACubeTheBitsOfABatchOnEveryInstructionSet) {
  const std::int64_t all = hwy::SupportedTargets();
  for_trees(10, [&](const Node& tree, Random& random) {
    const Block block = random_block(random, 30);
    const Compiled compiled = compile(tree, block);
    if (!compiled.kernel) return;
    Cube cube;
    cube.nx = static_cast<std::size_t>(random.whole(1, 16));
    cube.ny = static_cast<std::size_t>(random.whole(1, 16));
    const double step = (block.box.max.x - block.box.min.x) / 16;
    for (std::size_t i = 0; i < Cube::side; ++i) {
      cube.x[i] = cube.y[i] = cube.z[i] = static_cast<float>(static_cast<double>(i) * step);
    }
    std::vector<float> x, y, z, out(Cube::size);
    for (std::size_t n = 0; n < cube.nx * 256; ++n) {
      x.push_back(cube.x[n / 256]), y.push_back(cube.y[n / 16 % 16]), z.push_back(cube.z[n % 16]);
    }
    const auto batch = values(compiled, {x, y, z});
    for (std::int64_t target = all & -all; target != 0; target = target << 1) {
      if ((all & target) == 0) continue;
      hwy::SetSupportedTargetsForTest(target);
      AskedRows asked{};
      compiled.kernel->cube(cube, CubeValues(out.data(), Cube::size), asked);
      const auto again = values(compiled, {x, y, z});
      ASSERT_TRUE(same_bits(batch, again)) << hwy::TargetName(target);
      for (std::size_t i = 0; i < cube.nx; ++i) {
        const auto from = static_cast<std::ptrdiff_t>(256 * i);
        const auto n = static_cast<std::ptrdiff_t>(16 * cube.ny);
        std::vector<float> part(out.begin() + from, out.begin() + from + n);
        for (float& v : part) v += 0.0F;
        ASSERT_TRUE(same_bits(part, {batch.begin() + from, batch.begin() + from + n}))
            << hwy::TargetName(target);
        for (std::size_t k = 0; k < part.size(); ++k) {
          ASSERT_TRUE(part[k] == 0 || asked[16 * i + k / 16] != 0) << hwy::TargetName(target);
        }
      }
    }
    hwy::SetSupportedTargetsForTest(0);
  });
}

/// Central difference over `steps` steps of h along an axis, at every point of a cloud.
std::vector<double> difference(const Compiled& tree, const Cloud& cloud, int axis, float h) {
  Cloud ahead = cloud, behind = cloud;
  auto& up = axis == 0 ? ahead.x : axis == 1 ? ahead.y : ahead.z;
  auto& down = axis == 0 ? behind.x : axis == 1 ? behind.y : behind.z;
  for (float& v : up) v += h;
  for (float& v : down) v -= h;
  const auto f = values(tree, ahead.points()), b = values(tree, behind.points());
  std::vector<double> slope(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    slope[i] = (static_cast<double>(f[i]) - static_cast<double>(b[i])) /
               (static_cast<double>(up[i]) - static_cast<double>(down[i]));
  }
  return slope;
}

TEST_P(EveryNode, HasTheGradientOfItsValues) {
  std::size_t smooth = 0, kinks = 0, unlike = 0;
  std::ostringstream last;
  for_trees(3, [&](const Node& tree, Random& random) {
    const Block block = random_block(random, 12);
    const Compiled compiled = compile(tree, wide_block(block));
    const Cloud cloud(random, block, points_per_tree);
    const auto e = gradients(compiled, cloud.points());
    for (int axis = 0; axis < 3; ++axis) {
      const auto& slope = axis == 0 ? e.x : axis == 1 ? e.y : e.z;
      const auto narrow = difference(compiled, cloud, axis, 1.0F / 64);
      const auto wide = difference(compiled, cloud, axis, 1.0F / 32);
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        const double best = (4 * narrow[i] - wide[i]) / 3;  // Richardson
        const double steep = length({static_cast<double>(e.x[i]), static_cast<double>(e.y[i]),
                                     static_cast<double>(e.z[i])});
        if (steep == 0 && best == 0) continue;
        // What single precision leaves of a difference.
        const double noise = 5e-5 * (1 + std::abs(static_cast<double>(e.f[i]))) + 2e-4 * steep;
        const bool agrees = std::abs(static_cast<double>(slope[i]) - best) <= 1e-3 * steep + noise;
        const bool kink = std::abs(narrow[i] - wide[i]) > 0.01 * steep + noise;
        smooth += agrees;
        kinks += !agrees && kink;
        if (agrees || kink) continue;
        // A difference across a slight kink, or right on one, tells nothing by itself.
        ++unlike;
        last << "seed " << seed() << " axis " << axis << ": gradient " << slope[i]
             << ", difference " << best << " at " << cloud.x[i] << " " << cloud.y[i] << " "
             << cloud.z[i] << "\n";
      }
    }
  });
  EXPECT_GT(smooth, 1000u);
  EXPECT_GT(smooth, 8 * kinks);
  EXPECT_LE(unlike, smooth / 500) << last.str();
}

TEST_P(EveryNode, StaysWithinItsBoundsOverABox) {
  for_trees(4, [](const Node& tree, Random& random) {
    for (int box = 0; box < 5; ++box) {
      const Block block = random_block(random, 30);
      const Compiled compiled = compile(tree, block);
      const Cloud cloud(random, block, points_per_tree);
      for (const float v : values(compiled, cloud.points())) {
        ASSERT_TRUE(compiled.bounds.contains(static_cast<double>(v)))
            << v << " is not in [" << compiled.bounds.low << ", " << compiled.bounds.high << "]";
      }
    }
  });
}

/// Over a box of a tenth of a millimetre, but where the field jumps or a shape has two nearest
/// points on its boundary.
TEST_P(EveryNode, HasBoundsThatShrinkToItsValue) {
  std::size_t boxes = 0, wide = 0;
  for_trees(10, [&](const Node& tree, Random& random) {
    const Interval range = support(tree).range;
    const double most = 1e-3 + 0.02 * std::min(range.high - range.low, 1000.0);
    const Block block = random_block(random, 30);
    for (int i = 0; i < 20; ++i) {
      Vec3 at;
      for (int axis = 0; axis < 3; ++axis) {
        at[axis] = random.real(block.box.min[axis], block.box.max[axis]);
      }
      const Interval b = compile(tree, {at, Box{at, at}.grown(0.00005)}).bounds;
      ++boxes;
      wide += b.high - b.low > most ? 1 : 0;
    }
  });
  EXPECT_LE(wide, boxes / 50) << "of " << boxes;
}

TEST_P(EveryNode, StaysWithinItsRange) {
  for_trees(5, [](const Node& tree, Random& random) {
    const Interval range = outward(support(tree).range);
    const Block block = random_block(random, 60);
    for (const float v : values(compile(tree, block), Cloud(random, block, 1000).points())) {
      ASSERT_TRUE(range.contains(static_cast<double>(v)));
    }
  });
}

TEST_P(EveryNode, IsZeroOutsideItsInfluence) {
  for_trees(6, [](const Node& tree, Random& random) {
    const Box influence = support(tree).influence;
    const Block block = random_block(random, 60);
    const Cloud cloud(random, block, 1000);
    const auto v = values(compile(tree, wide_block(block)), cloud.points());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (!influence.contains(block.origin + cloud.at(i))) {
        ASSERT_EQ(v[i], 0.0F);
      }
    }
  });
}

TEST_P(EveryNode, GivesTheSameBitsInASmallBlockAsInAWideOne) {
  for_trees(7, [](const Node& tree, Random& random) {
    for (int box = 0; box < 5; ++box) {
      const Block block = random_block(random, 20);
      const Cloud cloud(random, block, points_per_tree);
      const Compiled small = compile(tree, block), wide = compile(tree, wide_block(block));
      ASSERT_TRUE(same_bits(values(small, cloud.points()), values(wide, cloud.points())));
      const auto a = gradients(small, cloud.points()), b = gradients(wide, cloud.points());
      ASSERT_TRUE(same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z));
      const Compiled cut = compile(prune(tree, block.box, 0), block);
      ASSERT_TRUE(same_bits(values(cut, cloud.points()), values(wide, cloud.points())));
    }
  });
}

TEST_P(EveryNode, KeepsItsLipschitzBound) {
  for_trees(8, [](const Node& tree, Random& random) {
    const double slope = support(tree).slope;
    if (!std::isfinite(slope)) return;
    const Block block = random_block(random, 30);
    const Cloud cloud(random, block, points_per_tree);
    const auto v = values(compile(tree, block), cloud.points());
    for (std::size_t i = 1; i < cloud.size(); ++i) {
      const double run = length(cloud.at(i) - cloud.at(i - 1));
      const double rise = static_cast<double>(v[i]) - static_cast<double>(v[i - 1]);
      ASSERT_LE(std::abs(rise), slope * run * (1 + 1e-5) + 1e-5);
    }
  });
}

/// Puts a number at an end of its range, here and there.
template <class N>
void stretch(N& node, Random& random) {
  const auto pull = [&](double& v, const Range& range) {
    const auto where = random.whole(0, 3);
    if (where == 0) v = range.open ? 1e-300 : range.low;
    if (where == 1) v = range.high;
  };
  const auto one = [&](const auto& f) {
    auto& member = node.*f.member;
    using Value = std::remove_cvref_t<decltype(member)>;
    if constexpr (std::is_same_v<Value, double>) {
      pull(member, f.range);
    } else if constexpr (std::is_same_v<Value, Vec3> && requires { f.range; }) {
      for (int axis = 0; axis < 3; ++axis) pull(member[axis], f.range);
    } else if constexpr (std::is_same_v<Value, StarTurbulence>) {
      stretch(member, random);
    }
  };
  std::apply([&](const auto&... f) { (one(f), ...); }, N::fields());
}

TEST_P(EveryNode, IsFiniteAtTheEndsOfItsRanges) {
  for_trees(9, [](Node tree, Random& random) {
    const Node whole = tree;
    const bool good = std::visit(
        [&](auto& node) {
          stretch(node, random);
          std::vector<Problem> problems;
          if constexpr (requires { node.check("", problems); }) node.check("", problems);
          return problems.empty();
        },
        tree.value);
    if (!good) tree = whole;
    const Block block = random_block(random, 30);
    const Cloud cloud(random, block, points_per_tree);
    const auto e = gradients(compile(tree, block), cloud.points());
    for (const auto* row : {&e.f, &e.x, &e.y, &e.z}) {
      for (const float v : *row) ASSERT_TRUE(std::isfinite(v));
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Nodes, EveryNode, testing::ValuesIn(node_kinds()), name_of);

}  // namespace

}  // namespace hoodoo::tree::conformance
