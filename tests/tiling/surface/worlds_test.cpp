#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/tiling/surface/topology.hpp"

namespace hoodoo::surface::testing {
namespace {

/// How many random worlds are tried; the environment variable HOODOO_WORLDS overrides it.
int world_count() {
  const char* wanted = std::getenv("HOODOO_WORLDS");
  return wanted != nullptr ? std::atoi(wanted) : 300;
}

struct World {
  Lattice lattice;
  std::vector<Box3> tiles;
  int units;

  Index low() const { return tiles.front().low; }
  Index high() const { return tiles.back().high; }

  /// The columns of cells that `p` touches, along one axis.
  std::array<std::int64_t, 2> columns(std::int64_t p) const {
    const std::int64_t cell = p >= 0 ? p / units : -((-p + units - 1) / units);
    return {p == cell * units ? cell - 1 : cell, cell};
  }
  /// Of the columns that `p` touches, those not in the world.
  int holes_at(const std::array<std::int64_t, 3>& p) const {
    const auto i = columns(p[0]), j = columns(p[1]);
    int count = 0;
    for (auto x = i[0]; x <= i[1]; ++x) {
      for (auto y = j[0]; y <= j[1]; ++y) count += lattice.in_world(x, y) ? 0 : 1;
    }
    return count;
  }
  bool on_outer_border(const std::array<std::int64_t, 3>& p) const {
    for (std::size_t a = 0; a < 3; ++a) {
      if (p[a] == low()[a] * units || p[a] == high()[a] * units) return true;
    }
    return false;
  }
};

World random_world(int seed, double holes, int units) {
  const auto random = [&](int what) {
    return unit_real(random_bits(std::uint64_t{977}, seed, what));
  };
  const double roughness = 0.05 + 0.9 * random(0);
  const Index low{-3 - seed % 13, -8 + seed % 5, -16};
  return {random_lattice(static_cast<std::uint64_t>(seed), roughness, seed % 3, holes),
          eight_tiles(low, 8), units};
}

/// Meshes every tile, then checks each alone and all together.
void expect_sound(const World& world) {
  std::vector<Net> tiles;
  for (const auto& [low, high] : world.tiles) {
    const auto surface = polygonize(fill(world.lattice, low, high), world.units);
    const Net net = net_of(surface, low, world.units);
    const auto ends = [&](std::uint32_t p) { return net.planes[p] != 0; };
    EXPECT_EQ(faults_of(net, ends, [](auto) { return false; }), Faults{});
    for (std::uint32_t p = 0; p < net.points.size(); ++p) {
      ASSERT_EQ((net.planes[p] & world_edge) != 0, world.holes_at(net.points[p]) > 0);
    }
    tiles.push_back(net);
  }
  const Net welded = weld(tiles);
  const auto ends = [&](std::uint32_t p) {
    return world.on_outer_border(welded.points[p]) || world.holes_at(welded.points[p]) > 0;
  };
  // Two columns that touch along a line only, with holes on both sides, meet in a point there.
  const auto pinches = [&](std::uint32_t p) { return world.holes_at(welded.points[p]) >= 2; };
  EXPECT_EQ(faults_of(welded, ends, pinches), Faults{});
}

class RandomWorlds : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Units, RandomWorlds, ::testing::Values(256, 300, 511));

TEST_P(RandomWorlds, AreClosedAndManifold) {
  for (int seed = 1; seed <= world_count() / 3 && !HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_sound(random_world(seed, 0, GetParam()));
  }
}

TEST_P(RandomWorlds, EndAtHolesAndNowhereElse) {
  for (int seed = 1; seed <= world_count() / 3 && !HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_sound(random_world(seed, 0.1 + 0.2 * (seed % 4), GetParam()));
  }
}

}  // namespace
}  // namespace hoodoo::surface::testing
