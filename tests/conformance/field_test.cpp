// Random worlds of bodies, operations and regions against the claims of engine/tree/field.hpp.
#include "engine/tree/field.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "engine/tree/node_type.hpp"
#include "engine/tree/region.hpp"
#include "tests/conformance/random_tree.hpp"

namespace hoodoo::tree::conformance {
namespace {

constexpr int worlds = 60;

struct World {
  Ground ground;
  std::vector<dem::Window> windows;
};

/// Bumpy ground about z = 0 around the scene, 2 m per pixel.
dem::Window random_window(Random& random) {
  constexpr int n = 64;
  std::vector<float> samples;
  for (int i = 0; i < n * n; ++i) samples.push_back(static_cast<float>(random.real(-4, 4)));
  return dem::Window(-64, -64, 2, 2, 0, 0, n, n, samples);
}

std::shared_ptr<const Region> random_region(Random& random) {
  Region region;
  region.feather = random.whole(0, 3) == 0 ? 0 : random.real(0.5, 8);
  const auto kind = random.whole(0, 3);
  if (kind == 0) {
    const Vec3 c = random.place(scene_size), h{8, 10, 6};
    region.box = {c - h, c + h};
  } else if (kind == 1) {
    region.box.min.z = random.real(-10, 0);
    region.box.max.z = random.real(0, 10);
  } else if (kind == 2) {
    for (const auto& [x, y] : {std::pair(-9.0, -8.0), {12.0, -10.0}, {3.0, 1.0}, {8.0, 14.0}}) {
      region.polygon.push_back({x + random.real(-3, 3), y + random.real(-3, 3)});
    }
  } else {
    region.mask = {-15, -15, 12, 18, 5, 4, {}};
    for (int i = 0; i < 20; ++i) {
      region.mask.weights.push_back(
          static_cast<float>(std::clamp(random.real(-0.5, 1.5), 0.0, 1.0)));
    }
  }
  return std::make_shared<const Region>(region);
}

World random_world(Random& random) {
  World world;
  for (long long i = random.whole(1, 2); i > 0; --i) {
    HeightBody body{"land", random.real(4, 12), random.whole(0, 2) == 0, i == 2, 0, {}};
    if (i == 2) {
      body.domain = {{-20, -20}, {15, -18}, {18, 20}, {-12, 12}};
      body.offset = random.real(-5, 5);
    }
    world.ground.bodies.push_back(body);
    world.windows.push_back(random_window(random));
  }
  for (long long i = random.whole(0, 5); i > 0; --i) {
    Step step{"",
              "",
              static_cast<Operation>(random.whole(0, 4)),
              random_tree(random, Family::terrain, 2),
              nullptr,
              static_cast<int>(random.whole(-1, 1))};
    if (random.whole(0, 1) == 0) step.region = random_region(random);
    world.ground.steps.push_back(std::move(step));
  }
  if (random.whole(0, 1) == 0) world.ground.geology = random_tree(random, Family::geology, 2);
  world.ground.materials = {{"soft", {}, 0, 0.4, 0.5}, {"hard", {}, 0.6, 1, 0.9}};
  return world;
}

/// Everything that a field says at some points.
struct Said {
  std::vector<float> f, x, y, z, rho;
  std::vector<int> material;
  explicit Said(const Field& field, const Points& at)
      : f(at.size()),
        x(at.size()),
        y(at.size()),
        z(at.size()),
        rho(at.size()),
        material(at.size()) {
    field.gradients(at, f, {x, y, z});
    field.resistances(at, rho);
    field.materials(at, material);
    if (const auto one = field.material()) {
      EXPECT_EQ(material, std::vector<int>(at.size(), *one));
    }
    std::vector<float> again(at.size());
    field.values(at, again);
    EXPECT_EQ(0, std::memcmp(again.data(), f.data(), f.size() * sizeof(float)));
  }
  testing::AssertionResult same_bits(const Said& other) const {
    const std::pair<const char*, std::vector<float> Said::*> rows[] = {
        {"F", &Said::f}, {"x", &Said::x}, {"y", &Said::y}, {"z", &Said::z}, {"rho", &Said::rho}};
    for (const auto& [name, row] : rows) {
      for (std::size_t i = 0; i < f.size(); ++i) {
        const float a = (this->*row)[i], b = (other.*row)[i];
        if (std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b)) continue;
        return testing::AssertionFailure() << name << " of point " << i << ": " << a << ", " << b;
      }
    }
    if (material == other.material) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "materials differ";
  }
};

template <class Check>
void for_worlds(std::uint64_t salt, Check check) {
  for (int i = 0; i < worlds; ++i) {
    const auto seed = salt * 1000 + static_cast<std::uint64_t>(i);
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const World world = random_world(random);
    check(world, random);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(Field, GivesTheSameBitsPrunedAndWhole) {
  for_worlds(1, [](const World& world, Random& random) {
    for (int i = 0; i < 8; ++i) {
      const Block block = random_block(random, 16);
      const Cloud cloud(random, block, 600);
      const auto small = compile(world.ground, world.windows, block.origin, block.box);
      const auto wide = compile(world.ground, world.windows, block.origin, wide_block(block).box);
      const Said whole(*wide, cloud.points());
      ASSERT_TRUE(Said(*small, cloud.points()).same_bits(whole));
      const Ground cut = prune(world.ground, block.box.grown(2), 0);
      const auto pruned = compile(cut, world.windows, block.origin, block.box);
      ASSERT_TRUE(Said(*pruned, cloud.points()).same_bits(whole));
    }
  });
}

/// Of `field` at the points of a grid, as a batch takes them.
std::vector<float> as_batch(const Field& field, const Grid& grid) {
  std::vector<float> x, y, z, out(grid.size());
  for (const float a : grid.x) {
    for (const float b : grid.y) {
      for (const float c : grid.z) {
        x.push_back(a), y.push_back(b), z.push_back(c);
      }
    }
  }
  field.values({x, y, z}, out);
  return out;
}

TEST(Field, GivesAGridTheBitsOfABatchOnEveryInstructionSet) {
  const std::int64_t all = hwy::SupportedTargets();
  for_worlds(5, [&](const World& world, Random& random) {
    const Block block = random_block(random, 16);
    const Block above{block.origin + Vec3{0, 0, 3}, {block.box.min, block.box.max + Vec3{0, 0, 3}}};
    const double step = (block.box.max.x - block.box.min.x) / 20;
    std::vector<float> x, y, z;
    const auto fill = [&](std::vector<float>& axis, long long most) {
      for (long long n = random.whole(1, most), i = 0; i < n; ++i) {
        axis.push_back(static_cast<float>(static_cast<double>(i) * step));
      }
    };
    fill(x, 18), fill(y, 18), fill(z, 20);
    const Grid grid{x, y, z};
    const auto low = compile(world.ground, world.windows, block.origin, block.box);
    const auto high = compile(world.ground, world.windows, above.origin, above.box);
    const std::vector<float> whole[] = {as_batch(*low, grid), as_batch(*high, grid)};
    for (std::int64_t target = all & -all; target != 0; target = target << 1) {
      if ((all & target) == 0) continue;
      hwy::SetSupportedTargetsForTest(target);
      Columns columns;
      std::vector<float> out(grid.size());
      const Field* fields[] = {low.get(), high.get()};
      for (std::size_t i = 0; i < 2; ++i) {
        fields[i]->grid(grid, out, &columns);
        EXPECT_EQ(0, std::memcmp(out.data(), whole[i].data(), out.size() * sizeof(float)))
            << hwy::TargetName(target);
      }
    }
    hwy::SetSupportedTargetsForTest(0);
  });
}

TEST(Field, StaysWithinItsBoundsAndTheUnitInterval) {
  for_worlds(2, [](const World& world, Random& random) {
    for (int i = 0; i < 8; ++i) {
      const Block block = random_block(random, 16);
      const Cloud cloud(random, block, 300);
      const auto field = compile(world.ground, world.windows, block.origin, block.box);
      const Interval bounds = field->bounds();
      for (const float v : Said(*field, cloud.points()).f) {
        ASSERT_TRUE(v >= 0 && v <= 1 && bounds.contains(static_cast<double>(v)));
      }
    }
  });
}

TEST(Field, GivesTheSameBitsOnEveryInstructionSet) {
  const std::int64_t all = hwy::SupportedTargets();
  for_worlds(3, [&](const World& world, Random& random) {
    const Block block = random_block(random, 16);
    const Cloud cloud(random, block, 300);
    const auto field = compile(world.ground, world.windows, block.origin, block.box);
    const Said best(*field, cloud.points());
    for (std::int64_t target = all & -all; target != 0; target = target << 1) {
      if ((all & target) == 0) continue;
      hwy::SetSupportedTargetsForTest(target);
      EXPECT_TRUE(Said(*field, cloud.points()).same_bits(best)) << hwy::TargetName(target);
    }
    hwy::SetSupportedTargetsForTest(0);
  });
}

TEST(Field, HasTheGradientOfItsValues) {
  std::size_t alike = 0, unlike = 0;
  for_worlds(4, [&](const World& world, Random& random) {
    for (const HeightBody& body : world.ground.bodies) {
      if (body.slope_corrected) return;  // whose factor the gradient takes as constant
    }
    const Block block = random_block(random, 16);
    const Cloud cloud(random, block, 300);
    const auto field = compile(world.ground, world.windows, block.origin, wide_block(block).box);
    const Said here(*field, cloud.points());
    constexpr float h = 1.0F / 64;
    for (int axis = 0; axis < 3; ++axis) {
      Cloud ahead = cloud, behind = cloud;
      for (float& v : axis == 0 ? ahead.x : axis == 1 ? ahead.y : ahead.z) v += h;
      for (float& v : axis == 0 ? behind.x : axis == 1 ? behind.y : behind.z) v -= h;
      const Said up(*field, ahead.points()), down(*field, behind.points());
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        const double steep = std::hypot(here.x[i], here.y[i], here.z[i]);
        const double right = static_cast<double>(up.f[i] - here.f[i]) / h;
        const double left = static_cast<double>(here.f[i] - down.f[i]) / h;
        const double slope = static_cast<double>(axis == 0   ? here.x[i]
                                                 : axis == 1 ? here.y[i]
                                                             : here.z[i]);
        if (std::abs(right - left) > 0.1 * steep + 1e-3) continue;  // a kink
        const bool good = std::abs(slope - (right + left) / 2) <= 2e-3 * steep + 2e-4;
        alike += good;
        unlike += !good;
      }
    }
  });
  EXPECT_LE(unlike, alike / 200);
}

}  // namespace
}  // namespace hoodoo::tree::conformance
