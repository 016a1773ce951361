#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/tiling/surface/topology.hpp"

namespace hoodoo::surface::testing {
namespace {

Net mesh(const Function& f, const Index& low, const Index& high, int units = 256) {
  return net_of(polygonize(fill(lattice_of(f), low, high), units), low, units);
}

double sphere(const Vec3& p) { return 13.3 - length(p - Vec3{20.2, 19.6, 20.4}); }

/// A ring about `center` in the plane across `axis`.
double torus(const Vec3& p, const Vec3& center, int axis, double ring, double tube) {
  Vec3 q = p - center;
  const double off = q[axis];
  q[axis] = 0;
  const double in_plane = length(q) - ring;
  return tube - std::sqrt(in_plane * in_plane + off * off);
}

double fbm(double x, double y) {
  double h = 0, a = 1, w = 64;
  for (std::uint64_t octave = 0; octave < 4; ++octave, a *= 0.5, w *= 0.5) {
    h += a * value_noise({x / w, y / w, 0.5}, 11 + octave);
  }
  return 12 * h;
}

Function noise(double wavelength, std::uint64_t seed) {
  return [=](const Vec3& p) { return value_noise(p * (1 / wavelength), seed); };
}

TEST(Polygonize, GivesNothingWithoutACrossing) {
  EXPECT_TRUE(polygonize(volume::Volume({-8, 0, 4}, {8, 20, 9}), 256).points.empty());
  const auto rock = fill(lattice_of([](const Vec3&) { return 1.0; }), {0, 0, 0}, {32, 32, 32});
  EXPECT_TRUE(polygonize(rock, 256).triangles.empty());
}

TEST(Polygonize, IsTheSameForTheSameVolume) {
  const auto volume = fill(random_lattice(5, 0.4, 0, 0.1), {-5, 3, 0}, {20, 30, 17});
  const auto a = polygonize(volume, 300), b = polygonize(volume, 300);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.materials, b.materials);
}

TEST(Polygonize, DoesNotDependOnWhichBlocksAreStored) {
  // The second is air in one octant of blocks: no block is mixed, and the cell at the octant's
  // corner lies in a block without a crossed edge of its own.
  const auto octant = [](const Vec3& p) { return 15.5 - std::min({p.x, p.y, p.z}); };
  for (const auto& f : {Function(sphere), Function(octant)}) {
    const auto lattice = lattice_of(f);
    const auto sparse = polygonize(fill(lattice, {0, 0, 0}, {40, 40, 40}), 256);
    const auto dense = polygonize(fill(lattice, {0, 0, 0}, {40, 40, 40}, Store::every_block), 256);
    EXPECT_GT(sparse.triangles.size(), 1000U);
    EXPECT_EQ(sparse.points, dense.points);
    EXPECT_EQ(sparse.triangles, dense.triangles);
  }
}

TEST(Polygonize, KeepsEulersNumberOfABallAndARing) {
  EXPECT_EQ(euler_characteristic(mesh(sphere, {0, 0, 0}, {40, 40, 40})), 2);
  const auto ring = [](const Vec3& p) { return torus(p, {20.3, 20.1, 15.7}, 2, 10, 4); };
  EXPECT_EQ(euler_characteristic(mesh(ring, {0, 0, 0}, {40, 40, 32})), 0);
}

TEST(Polygonize, KeepsAnArchAndATunnelOnADisk) {
  const auto ground = [](const Vec3& p) {
    const double arch = torus(p, {16.2, 24.1, 20.3}, 1, 9, 2.6);
    const double tunnel = torus(p, {46.3, 24.4, 20.3}, 1, 9, 2.6);
    return std::min(std::max(20.3 - p.z, arch), -tunnel);
  };
  EXPECT_EQ(euler_characteristic(mesh(ground, {0, 0, 0}, {64, 48, 40})), -3);
}

TEST(Polygonize, TurnsTrianglesCounterClockwiseSeenFromTheAir) {
  const Net net = mesh(sphere, {0, 0, 0}, {40, 40, 40});
  double six_volumes = 0;
  for (const auto& t : net.triangles) {
    std::array<Vec3, 3> p;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t d = 0; d < 3; ++d) {
        p[i][static_cast<int>(d)] = static_cast<double>(net.points[t[i]][d]) / 256;
      }
    }
    six_volumes += dot(p[0], cross(p[1], p[2]));
  }
  EXPECT_NEAR(six_volumes / 6, 4.0 / 3 * 3.14159265 * 13.3 * 13.3 * 13.3, 100);
}

TEST(Polygonize, MarksEveryVertexOnABorderPlaneAndNoOther) {
  const Index low{3, -20, 8}, high{25, 7, 40};
  const auto surface = polygonize(fill(random_lattice(9, 0.5, 0, 0), low, high), 256);
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    unsigned expected = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      if (surface.points[i][a] == 0) expected |= 1U << (2 * a);
      if (surface.points[i][a] == (high[a] - low[a]) * 256) expected |= 2U << (2 * a);
    }
    ASSERT_EQ(surface.planes[i], expected);
  }
}

/// Distances of vertices inside cells to the surface, in cells.
struct Accuracy {
  double mean = 0, most = 0;
};
Accuracy accuracy(const Function& f) {
  const Net net = mesh(f, {0, 0, 0}, {40, 40, 40});
  Accuracy a;
  double count = 0;
  for (std::size_t i = 0; i < net.points.size(); ++i) {
    if (net.planes[i] != 0) continue;
    const auto& p = net.points[i];
    const double d =
        distance_to_surface(f, Vec3{double(p[0]), double(p[1]), double(p[2])} * (1.0 / 256));
    a.mean += d;
    a.most = std::max(a.most, d);
    ++count;
  }
  EXPECT_GT(count, 1000);
  a.mean /= count;
  return a;
}

struct Row {
  const char* name;
  Function f;
  double mean, most;
};

/// notes/dual_contouring.md, section 5, column "1/256 + snap". The noise there has other random
/// values, so its rows leave room.
TEST(Polygonize, IsAsAccurateAsMeasuredForThePrototype) {
  const std::vector<Row> rows = {
      {"plane",
       [](const Vec3& p) {
         return dot({0.267, 0.535, 0.802}, p - Vec3{20.1, 19.7, 20.3});
       },
       .00098, .0026},
      {"slope of 5 %", [](const Vec3& p) { return 20.37 + 0.05 * p.x + 0.013 * p.y - p.z; }, .00101,
       .0043},
      {"plane on the lattice", [](const Vec3& p) { return 20 - p.z; }, .00391, .00392},
      {"sphere", sphere, .0145, .027},
      {"noise of wavelength 16", noise(16, 3), .0135, .18},
      {"noise of wavelength 8", noise(8, 4), .0265, .55},
      {"terrain", [](const Vec3& p) { return fbm(p.x, p.y) + 20 - p.z; }, .0075, .055},
  };
  for (const auto& row : rows) {
    const auto a = accuracy(row.f);
    EXPECT_LE(a.mean, row.mean) << row.name;
    EXPECT_LE(a.most, row.most) << row.name;
    RecordProperty(std::string(row.name) + " mean", std::to_string(a.mean));
    RecordProperty(std::string(row.name) + " most", std::to_string(a.most));
  }
}

}  // namespace
}  // namespace hoodoo::surface::testing
