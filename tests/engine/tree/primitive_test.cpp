// Values computed by hand from the formulas of DESIGN section 3 (Paris et al. 2019, section 5.2).
#include <gtest/gtest.h>

#include <cmath>

#include "tests/engine/tree/probe.hpp"

namespace hoodoo::tree {
namespace {

constexpr double near_zero = 2e-6;

TEST(Falloff, IsOneHalfAtItsRoot) {
  // (1 - x^2)^3 = 1/2 at x = sqrt(1 - 2^(-1/3)).
  const double x2 = half_falloff * half_falloff;
  EXPECT_NEAR((1 - x2) * (1 - x2) * (1 - x2), 0.5, 1e-15);
}

TEST(Falloff, FollowsTheSixthDegreePolynomial) {
  // R = 10: g(0) = 1, g(5) = 0.75^3, g(8) = 0.36^3, g(10) = 0.
  const Node p{dot_at({0, 0, 0}, 10 * half_falloff)};
  EXPECT_NEAR(value(p, {0, 0, 0}), 1, near_zero);
  EXPECT_NEAR(value(p, {5, 0, 0}), 0.421875, near_zero);
  EXPECT_NEAR(value(p, {0, 8, 0}), 0.046656, near_zero);
  EXPECT_EQ(value(p, {0, 0, 10}), 0);
  EXPECT_EQ(value(p, {7, 7, 7}), 0);
  // dg/dr = -6 r / R^2 (1 - r^2/R^2)^2 = -0.3 * 0.5625 at r = 5.
  EXPECT_NEAR(probe(p, {5, 0, 0}).gradient.x, -0.16875, near_zero);
}

/// Every primitive alone has its surface where its size says.
TEST(Primitive, HasItsSurfaceAtTheStatedSize) {
  const auto on_surface = [](const Node& n, const Vec3& p) { EXPECT_NEAR(value(n, p), 0.5, 1e-5); };
  on_surface({dot_at({1, 2, 3}, 4)}, {5, 2, 3});
  on_surface({ball({1, 2, 3}, 4, 2)}, {1, 2, 7});
  Segment s;
  s.from = Vec3{0, 0, 0};
  s.to = Vec3{10, 0, 0};
  s.radius = 3;
  on_surface({s}, {5, 3, 0});
  on_surface({s}, {-3, 0, 0});
  Polyline line;
  line.points = {Vec3{0, 0, 0}, Vec3{10, 0, 0}, Vec3{10, 10, 0}};
  line.radius = 2;
  on_surface({line}, {5, -2, 0});
  on_surface({line}, {12, 5, 0});
  EXPECT_EQ(value({line}, {0, 10, 0}), 0);
  line.closed = true;
  on_surface({line}, {5 - std::sqrt(2.0), 5 + std::sqrt(2.0), 0});
  BoxNode box;
  box.center = Vec3{0, 0, 0};
  box.size = {6, 8, 10};
  on_surface({box}, {3, 1, 1});
  on_surface({box}, {1, -4, 2});
  on_surface({box}, {1, 2, 5});
  Cone cone;
  cone.base = Vec3{0, 0, 0};
  cone.tip = Vec3{0, 0, 8};
  cone.radius = 6;
  on_surface({cone}, {3, 0, 4});
  on_surface({cone}, {1, 1, 0});
  Ellipsoid e;
  e.center = Vec3{0, 0, 0};
  e.radii = {3, 5, 8};
  on_surface({e}, {3, 0, 0});
  on_surface({e}, {0, -5, 0});
  on_surface({e}, {0, 0, 8});
  on_surface({e}, {3 / std::sqrt(3.0), 5 / std::sqrt(3.0), 8 / std::sqrt(3.0)});
}

TEST(Primitive, OfACurvePassesThroughItsPointsAndEnds) {
  CatmullRom curve;
  curve.points = {Vec3{0, 0, 0}, Vec3{10, 0, 0}, Vec3{20, 10, 0}};
  curve.radius = 2;
  for (const Point& p : curve.points) EXPECT_NEAR(value({curve}, p.value), 1, 1e-4);
  // Half way along the first span: (0 + 10) / 2 + (0 - 2 * 10 + ...) / 16, by the basis
  // (-1, 9, 9, -1) / 16 on (-10, 0), (0, 0), (10, 0), (20, 10).
  EXPECT_NEAR(value({curve}, {5, -0.625, 0}), 1, 1e-3);
  EXPECT_NEAR(value({curve}, {5, -0.625, 2}), 0.5, 1e-3);
  curve.closed = true;
  EXPECT_GT(value({curve}, {10, 5, 0}), 0);
  Bezier arch;
  arch.points = {Vec3{0, 0, 0}, Vec3{0, 0, 8}, Vec3{8, 0, 8}, Vec3{8, 0, 0}};
  arch.radius = 1;
  // B(1/2) = (0 + 3 * 0 + 3 * 8 + 8) / 8, 6 * 8 / 8.
  EXPECT_NEAR(value({arch}, {4, 0, 6}), 1, 1e-2);
  EXPECT_NEAR(value({arch}, {4, 1, 6}), 0.5, 1e-2);
  EXPECT_NEAR(value({arch}, {8, 0, 0}), 1, 1e-5);
}

TEST(Primitive, UsesTheExactDistanceToRoundSolids) {
  const auto d = [](const Node& n, const Vec3& p) {
    return 20 * (std::sqrt(1 - std::cbrt(value(n, p))) - half_falloff);
  };
  RoundedBox stone;
  stone.center = Vec3{0, 0, 0};
  stone.size = {6, 8, 10};
  stone.rounding = 1;
  stone.falloff = 20;
  EXPECT_NEAR(d({stone}, {5, 0, 0}), 2, 2e-4);
  EXPECT_NEAR(d({stone}, {2 + 3, 3 + 4, 0}), 4, 2e-4);  // 5 from the inner block's edge
  EXPECT_NEAR(d({stone}, {0, 0, 0}), -3, 2e-4);
  TruncatedCone cone;
  cone.base = Vec3{0, 0, 0};
  cone.top = Vec3{0, 0, 4};
  cone.base_radius = 6;
  cone.top_radius = 3;
  cone.falloff = 20;
  EXPECT_NEAR(d({cone}, {1, 0, 6}), 2, 2e-4);                // the top
  EXPECT_NEAR(d({cone}, {1, 0, -2}), 2, 2e-4);               // the base
  EXPECT_NEAR(d({cone}, {4.5 + 0.8, 0, 2 + 0.6}), 1, 2e-4);  // the mantle
  EXPECT_NEAR(d({cone}, {9, 0, -4}), 5, 2e-4);               // the rim
  EXPECT_NEAR(d({cone}, {4.5 - 0.8, 0, 2 - 0.6}), -1, 2e-4);
  EXPECT_NEAR(cone.half_thickness(), 2, 1e-12);
  Cylinder column;
  column.base = Vec3{0, 0, 0};
  column.top = Vec3{10, 0, 0};
  column.radius = 3;
  column.falloff = 20;
  EXPECT_NEAR(d({column}, {5, 0, 5}), 2, 2e-4);
  EXPECT_NEAR(d({column}, {13, 7, 0}), 5, 2e-4);
  EXPECT_NEAR(d({column}, {5, 0, 1}), -2, 2e-4);
  Capsule pill;
  pill.from = Vec3{0, 0, 0};
  pill.to = Vec3{10, 0, 0};
  pill.radius = 3;
  pill.falloff = 20;
  EXPECT_NEAR(d({pill}, {13, 4, 0}), 2, 2e-4);
  EXPECT_NEAR(d({pill}, {5, 0, 0}), -3, 2e-4);
  Torus ring;
  ring.center = Vec3{0, 0, 0};
  ring.radius = 5;
  ring.tube = 2;
  ring.falloff = 20;
  EXPECT_NEAR(d({ring}, {0, 8, 4}), 3, 2e-4);
  EXPECT_NEAR(d({ring}, {0, 0, 0}), 3, 2e-4);
  EXPECT_NEAR(d({ring}, {5, 0, 0}), -2, 2e-4);
  HalfSpace half;
  half.point = Vec3{0, 0, 5};
  half.normal = {0, 3, 4};
  half.falloff = 20;
  EXPECT_NEAR(d({half}, {100, 3, 9}), 5, 2e-4);
  EXPECT_NEAR(d({half}, {-50, -3, 1}), -5, 2e-4);
}

TEST(Primitive, FallsOffFromTheSurfaceOfAVolume) {
  // d = 0.5 outside, R = 2: g(0.5 + 0.9084040) = (1 - 0.7042020^2)^3.
  const Node n{ball({0, 0, 0}, 5, 2)};
  EXPECT_NEAR(value(n, {5.5, 0, 0}), std::pow(1 - 0.70420202 * 0.70420202, 3), near_zero);
  // Deeper than 0.4542 R the field is at its peak.
  EXPECT_EQ(value(n, {4, 0, 0}), 1);
  EXPECT_EQ(value(n, {0, 0, 0}), 1);
  // It ends 0.5458 R outside.
  EXPECT_GT(value(n, {6.09, 0, 0}), 0);
  EXPECT_EQ(value(n, {6.0917, 0, 0}), 0);
  EXPECT_NEAR(value({ball({0, 0, 0}, 5, 2, -3)}, {0, 0, 0}), -3, near_zero);
}

/// Distances from outside, by hand: the value tells them apart through g.
double distance_from_value(double f, double falloff) {
  return falloff * (std::sqrt(1 - std::cbrt(f)) - half_falloff);
}

TEST(Primitive, UsesTheDistanceToTheNearestPointOfTheBoundary) {
  BoxNode box;
  box.center = Vec3{0, 0, 0};
  box.size = {2, 2, 2};
  box.falloff = 10;
  // Corner (1,1,1) to (2,3,3): sqrt(1 + 4 + 4) = 3.
  EXPECT_NEAR(distance_from_value(value({box}, {2, 3, 3}), 10), 3, 1e-4);
  EXPECT_NEAR(distance_from_value(value({box}, {4, 0.5, 0}), 10), 3, 1e-4);
  EXPECT_NEAR(distance_from_value(value({box}, {0.5, 0, 0}), 10), -0.5, 1e-4);
  Cone cone;
  cone.base = Vec3{0, 0, 0};
  cone.tip = Vec3{0, 0, 4};
  cone.radius = 3;
  cone.falloff = 10;
  EXPECT_NEAR(distance_from_value(value({cone}, {0, 0, 6}), 10), 2, 1e-4);   // the tip
  EXPECT_NEAR(distance_from_value(value({cone}, {1, 0, -2}), 10), 2, 1e-4);  // the base
  EXPECT_NEAR(distance_from_value(value({cone}, {6, 0, -4}), 10), 5, 2e-4);  // the rim
  EXPECT_NEAR(distance_from_value(value({cone}, {1.5 + 0.8, 0, 2 + 0.6}), 10), 1, 1e-4);  // mantle
  EXPECT_NEAR(distance_from_value(value({cone}, {0, 0, 1}), 10), -1, 1e-4);
  Ellipsoid e;
  e.center = Vec3{0, 0, 0};
  e.radii = {2, 3, 4};
  e.falloff = 20;
  EXPECT_NEAR(distance_from_value(value({e}, {0, 0, 9}), 20), 5, 1e-4);
  EXPECT_NEAR(distance_from_value(value({e}, {0, 0, 0}), 20), -2, 1e-4);
}

TEST(Ellipsoid, EqualsASphereWhereItsAxesAreEqual) {
  Ellipsoid e;
  e.center = Vec3{1, 2, 3};
  e.radii = {4, 4, 4};
  e.falloff = 6;
  const Node round{ball({1, 2, 3}, 4, 6)};
  for (const Vec3& p : {Vec3{1, 2, 3}, Vec3{2, 4, 6}, Vec3{5, 2, 3}, Vec3{-2, 4, 6}}) {
    EXPECT_NEAR(value({e}, p), value(round, p), 1e-5);
  }
}

/// A negative sphere of energy e in deep rock (F = 1) carves R sqrt(1 - (1/(2e))^(1/3)).
TEST(Carving, OpensTheRadiusOfTheFormula) {
  const double R = 10;
  const auto carved = [&](double energy, double r) {
    return 1 + value({dot_at({0, 0, 0}, R * half_falloff, -energy)}, {r, 0, 0});
  };
  EXPECT_NEAR(carved(0.5, 0), 0.5, near_zero);  // nothing at e = 1/2
  for (const double e : {0.75, 1.0, 2.0, 4.0}) {
    const double r = R * std::sqrt(1 - std::cbrt(1 / (2 * e)));
    EXPECT_NEAR(carved(e, r), 0.5, 1e-5) << e;
  }
  EXPECT_NEAR(R * std::sqrt(1 - std::cbrt(1 / 2.0)), 4.542, 1e-3);
  EXPECT_NEAR(R * std::sqrt(1 - std::cbrt(1 / 4.0)), 6.083, 1e-3);
}

TEST(StarTurbulence, MovesTheBoundaryByNoMoreThanItsAmplitude) {
  Sphere rough = ball({0, 0, 0}, 10, 4);
  rough.turbulence = {1.5, 5, 3, 7};
  double least = 100, most = 0;
  for (int i = 0; i < 400; ++i) {
    const double a = 2.399963 * i, z = (i + 0.5) / 200 - 1, s = std::sqrt(1 - z * z);
    const Vec3 u{s * std::cos(a), s * std::sin(a), z};
    // The surface along this ray, by bisection: star-shaped, so there is one.
    double in = 0, out = 20;
    for (int k = 0; k < 40; ++k) {
      const double mid = (in + out) / 2;
      (value({rough}, u * mid) > 0.5 ? in : out) = mid;
    }
    least = std::min(least, in);
    most = std::max(most, in);
  }
  EXPECT_GE(least, 8.5);
  EXPECT_LE(most, 11.5);
  EXPECT_LT(least, 9.6);
  EXPECT_GT(most, 10.4);
}

TEST(StarTurbulence, MovesAThinSurfaceInProportion) {
  PointNode rough = dot_at({0, 0, 0}, 10 * half_falloff);
  rough.turbulence = {4, 5, 3, 7};
  // R between 6 and 14: nothing beyond 14, something within 6.
  for (int i = 0; i < 200; ++i) {
    const double a = 2.399963 * i, z = (i + 0.5) / 100 - 1, s = std::sqrt(1 - z * z);
    const Vec3 u{s * std::cos(a), s * std::sin(a), z};
    EXPECT_EQ(value({rough}, u * 14.001), 0);
    EXPECT_GT(value({rough}, u * 5.999), 0);
  }
  EXPECT_NEAR(value({rough}, {0, 0, 0}), 1, near_zero);
}

TEST(Geology, StrataLieLevelAndPlanesFallOffOnBothSides) {
  Strata strata;
  strata.wavelength = 6;
  EXPECT_EQ(value({strata}, {100, -50, 7}), value({strata}, {-3, 8, 7}));
  EXPECT_NE(value({strata}, {0, 0, 7}), value({strata}, {0, 0, 8}));
  Plane plane;
  plane.point = Vec3{0, 0, 10};
  plane.normal = {0, 0, 2};
  plane.falloff = 4;
  plane.energy = -0.5;
  EXPECT_NEAR(value({plane}, {7, 8, 10}), -0.5, near_zero);
  EXPECT_NEAR(value({plane}, {7, 8, 12}), -0.5 * 0.421875, near_zero);
  EXPECT_NEAR(value({plane}, {7, 8, 8}), -0.5 * 0.421875, near_zero);
  EXPECT_EQ(value({plane}, {7, 8, 15}), 0);
}

}  // namespace
}  // namespace hoodoo::tree
