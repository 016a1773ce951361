#include "tiling/volume/ready_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace hoodoo::volume {
namespace {

/// A ball of radius 9 about (13.2, 17.6, 11.4): solid where above 0.
std::vector<float> ball(const std::array<int, 3>& size) {
  std::vector<float> values;
  for (int z = 0; z < size[2]; ++z) {
    for (int y = 0; y < size[1]; ++y) {
      for (int x = 0; x < size[0]; ++x) {
        const double dx = x - 13.2, dy = y - 17.6, dz = z - 11.4;
        values.push_back(static_cast<float>(9 - std::sqrt(dx * dx + dy * dy + dz * dz)));
      }
    }
  }
  return values;
}

TEST(ReadyGrid, HasTheSignsCrossingsAndNormalsOfItsValues) {
  const std::array<int, 3> size{27, 35, 24};  // no multiples of a block
  const auto values = ball(size);
  const ReadyGrid grid{values, size, 0};
  const Volume volume = volume_of(grid);
  for (int z = 0; z < size[2]; ++z) {
    for (int y = 0; y < size[1]; ++y) {
      for (int x = 0; x < size[0]; ++x) {
        ASSERT_EQ(volume.solid({x, y, z}), grid.at(x, y, z) > 0) << x << ' ' << y << ' ' << z;
      }
    }
  }
  int crossings = 0;
  volume.for_each_crossing([&](int axis, const Index& p) {
    ++crossings;
    const Crossing& c = volume.crossing(axis, p);
    Vec3 at{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
    at[axis] += static_cast<double>(c.t);
    const Vec3 out = at - Vec3{13.2, 17.6, 11.4};
    EXPECT_NEAR(length(out), 9, 0.02);
    EXPECT_GT(dot(normalized(out), {c.normal.x, c.normal.y, c.normal.z}), 0.998);
  });
  EXPECT_GT(crossings, 1000);
}

}  // namespace
}  // namespace hoodoo::volume
