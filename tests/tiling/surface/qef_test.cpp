#include "tiling/surface/qef.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <vector>

#include "engine/base/random.hpp"

namespace hoodoo::surface {
namespace {

Vec3 solve(const std::vector<Plane3>& planes) {
  const Vec3 mean = mean_point(planes);
  return mean + minimise(planes, mean);
}

TEST(Qef, FindsTheCornerOfThreePlanes) {
  const Vec3 corner{0.3, 0.6, 0.2};
  const Vec3 found =
      solve({{{0.3, 0, 1}, {1, 0, 0}}, {{0, 0.6, 0}, {0, 1, 0}}, {{1, 1, 0.2}, {0, 0, 1}}});
  EXPECT_LT(length(found - corner), 1e-12);
}

TEST(Qef, StaysNearTheMeanAlongACreaseAndOnAPlane) {
  // A crease along y: the free direction keeps the mean.
  const Vec3 crease = solve({{{0.2, 0, 0.5}, {1, 0, 0}}, {{0.5, 1, 0.7}, {0, 0, 1}}});
  EXPECT_LT(length(crease - Vec3{0.2, 0.5, 0.7}), 1e-12);
  const Vec3 n = normalized({1, 2, 5});
  const Vec3 flat = solve({{{0, 0, 0.5}, n}, {{1, 0, 0.3}, n}, {{0, 1, 0.1}, n}});
  EXPECT_NEAR(dot(flat - mean_point(std::vector<Plane3>{
                             {{0, 0, 0.5}, n}, {{1, 0, 0.3}, n}, {{0, 1, 0.1}, n}}),
                  n),
              0, 1e-12);
}

/// The same by a library's eigenvectors.
Vec3 truncated_inverse(const std::vector<Plane3>& planes, const Vec3& mean) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const auto& [point, normal] : planes) {
    const Eigen::Vector3d n(normal.x, normal.y, normal.z);
    m += n * n.transpose();
    b += n * dot(normal, point - mean);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(m);
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d v = solver.eigenvectors().col(i);
    const double w = solver.eigenvalues()[i];
    if (w > 0.1 * solver.eigenvalues()[2]) x += v * (v.dot(b) / w);
  }
  return {x[0], x[1], x[2]};
}

TEST(Qef, AgreesWithALibraryFromFlatToSharp) {
  for (std::uint64_t seed = 0; seed < 5000; ++seed) {
    const double spread = 2 * unit_real(random_bits(seed));
    std::vector<Plane3> planes;
    for (int i = 0; i < 4; ++i) {
      const auto random = [&](int what) { return unit_real(random_bits(seed, i, what)); };
      const Vec3 normal{spread * (random(0) - 0.5), spread * (random(1) - 0.5), 1};
      planes.push_back({{i % 2 * 1.0, i / 2 * 1.0, random(2)}, normalized(normal)});
    }
    const Vec3 mean = mean_point(planes);
    const Vec3 offset = minimise(planes, mean);
    EXPECT_LT(length(offset - truncated_inverse(planes, mean)), 1e-3) << "seed " << seed;
  }
}

using Lines = std::array<Line2, 2>;
using Point2 = std::array<double, 2>;

TEST(QefInAFace, MeetsTheTwoLinesOrStaysAtTheMean) {
  const Lines crossing_lines{Line2{{0.2, 0}, {1, 0}}, Line2{{0, 0.6}, {0, 3}}};
  const auto corner = minimise(crossing_lines, Point2{0.1, 0.3});
  EXPECT_NEAR(corner[0], 0.1, 1e-12);
  EXPECT_NEAR(corner[1], 0.3, 1e-12);
  const Lines parallel_lines{Line2{{0, 0.4}, {0, 1}}, Line2{{1, 0.6}, {0, 1}}};
  const auto parallel = minimise(parallel_lines, Point2{0.5, 0.5});
  EXPECT_NEAR(parallel[0], 0, 1e-12);
  EXPECT_NEAR(parallel[1], 0, 1e-12);
  const Lines no_lines{Line2{{0, 0.4}, {0, 0}}, Line2{{1, 0.6}, {0, 1e-9}}};
  EXPECT_EQ(minimise(no_lines, Point2{0.5, 0.5}), (Point2{0, 0}));
}

}  // namespace
}  // namespace hoodoo::surface
