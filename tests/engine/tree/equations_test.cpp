// Equations of the seeds against values computed by hand. Each row names its equation; the units
// are those of DESIGN section 3, where the surface lies at F = 1/2.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/noise.hpp"
#include "engine/tree/body.hpp"
#include "tests/engine/tree/probe.hpp"

namespace hoodoo::tree {
namespace {

struct Row {
  double computed, byhand;
  double tolerance = 3e-6;
};

void expect(const char* equation, const std::vector<Row>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(rows[i].computed, rows[i].byhand, rows[i].tolerance)
        << equation << ", row " << i + 1;
  }
}

Expression formula(std::string text) {
  Expression e;
  e.formula = std::move(text);
  return e;
}

TEST(Equation, Falloff) {
  const Node p{dot_at({0, 0, 0}, 10 * half_falloff)};
  const auto g = [&](double r) { return value(p, {r, 0, 0}); };
  expect("Paris 2019, 3.3: g(r) = (1 - (r/R)^2)^3, R = 10", {{g(0), 1},
                                                             {g(1), 0.970299},
                                                             {g(2), 0.884736},
                                                             {g(3), 0.753571},
                                                             {g(4), 0.592704},
                                                             {g(5), 0.421875},
                                                             {g(6), 0.262144},
                                                             {g(7), 0.132651},
                                                             {g(8), 0.046656},
                                                             {g(9), 0.006859},
                                                             {g(10), 0},
                                                             {g(11), 0}});
}

/// F_T of level ground at z = 0, R = 8.
double ground(double z, bool with_domain = false, double x = 0) {
  static const dem::Window level(-40, -40, 10, 10, 0, 0, 8, 8, std::vector<float>(64, 0.0F));
  HeightBody body{"land", 8, false, false, 0, {}};
  if (with_domain) body.domain = {{-30, -30}, {10, -30}, {10, 30}, {-30, 30}};
  const BodyField field(body, level, {{0, 0, 0}, Box{{0, 0, 0}, {0, 0, 0}}.grown(20)});
  const auto px = static_cast<float>(x), pz = static_cast<float>(z);
  const float py = 0;
  float f = 0;
  field.values({{&px, 1}, {&py, 1}, {&pz, 1}}, {&f, 1});
  return static_cast<double>(f);
}

TEST(Equation, Sigma) {
  expect("Paris 2019, 5.1 (mended): F_T = (1 + s(v/R))/2, s(u) = (3u - u^3)/2, R = 8",
         {{ground(0), 0.5},
          {ground(-2), 0.68359375},
          {ground(-4), 0.84375},
          {ground(-6), 0.95703125},
          {ground(-8), 1},
          {ground(-9), 1},
          {ground(2), 0.31640625},
          {ground(4), 0.15625},
          {ground(6), 0.04296875},
          {ground(8), 0},
          {ground(12), 0}});
}

TEST(Equation, Prism) {
  expect("Paris 2019, 5.1: f = min(f_T, f_P), F_P = (1 + s(d/R))/2, d to the edge x = 10, R = 8",
         {{ground(-9, true, 2), 1},
          {ground(-9, true, 8), 0.68359375},
          {ground(-9, true, 10), 0.5},
          {ground(-9, true, 14), 0.15625},
          {ground(-9, true, 18), 0},
          {ground(2, true, 8), 0.31640625},
          {ground(0, true, 14), 0.15625}});
  Prism prism;
  prism.outline = {{0, 0}, {20, 0}, {20, 20}, {0, 20}};
  prism.bottom = 0;
  prism.top = 20;
  prism.falloff = 10;
  const auto f = [&](const Vec3& p) { return value({prism}, p); };
  // A distance of 1 - 4.5420202 is one of 1 to where g begins, and so on.
  const double d = -10 * half_falloff;
  expect("Paris 2019, 5.1 and 5.2: f_P = g(d(p, P))",
         {{f({10, 10, 10}), 1},
          {f({20, 10, 10}), 0.5},
          {f({10, 10, 20}), 0.5},
          {f({20 + d + 6, 10, 10}), 0.262144},
          {f({10, 20 + d + 8, 10}), 0.046656},
          {f({10, 10, 20 + d + 5}), 0.421875},
          {f({10, 10, -d - 5}), 0.421875},
          // 3 and 4 over two faces: a distance of 5 to the edge.
          {f({23, 24, 10}), std::pow(1 - std::pow(0.5 + half_falloff, 2), 3)},
          {f({26, 10, 10}), 0}});
}

TEST(Equation, StarShapedDistance) {
  PointNode rough = dot_at({0, 0, 0}, 10 * half_falloff);
  rough.turbulence = {4, 5, 3, 7};
  std::vector<Row> rows;
  for (const double r : {1.0, 3.0, 5.0, 7.0}) {
    for (const Vec3& u : {Vec3{1, 0, 0}, Vec3{0, -0.6, 0.8}}) {
      // v = s + radius u; R becomes R + a (2t - 1).
      const Vec3 v = u * rough.radius;
      const float zero = 0;
      float t = 0;
      turbulence(rough.turbulence.noise(), v, {&zero, 1}, {&zero, 1}, {&zero, 1}, {&t, 1});
      const double ratio = r / (10 + 4 * (2 * static_cast<double>(t) - 1));
      rows.push_back({value({rough}, u * r), std::pow(std::max(0.0, 1 - ratio * ratio), 3), 2e-4});
    }
  }
  expect("Paris 2019, 5.2 (mended): d = |p - s| / (R + a (2 t(v) - 1)), v = s + R u", rows);
}

TEST(Equation, Operators) {
  const Node a{formula("0.3")}, b{formula("0.8")};
  const auto f = [](const Node& n) { return value(n, {1, 2, 3}); };
  expect("Paris 2019, 5.3 (mended): sum; max; min; min(A, 1 - B); A - B",
         {{f({Blend{}, {a, b}}), 1.1},
          {f({Union{}, {a, b}}), 0.8},
          {f({Intersection{}, {a, b}}), 0.3},
          {f({Difference{}, {a, b}}), 0.2},
          {f({Difference{}, {b, a}}), 0.7},
          {f({Carve{}, {b, a}}), 0.5},
          {f({Multiply{}, {a, b}}), 0.24}});
}

TEST(Equation, Erosion) {
  const auto f = [](const char* body, const char* control, const char* rho, double amount) {
    Erosion e;
    e.amount = amount;
    return value({e, {{formula(rho)}, {formula(control)}, {formula(body)}}}, {1, 2, 3});
  };
  expect("Paris 2019, 5.3: f - a f_D (1 - rho)", {{f("0.8", "1", "0", 1), -0.2},
                                                  {f("0.8", "1", "1", 1), 0.8},
                                                  {f("0.8", "1", "0.25", 1), 0.05},
                                                  {f("0.8", "0.5", "0.25", 0.6), 0.575},
                                                  {f("0.8", "0", "0.25", 1), 0.8},
                                                  {f("0.8", "7", "-3", 0.5), 0.3},
                                                  {f("0", "0.5", "0.5", 2), -0.5}});
}

TEST(Equation, FaultJump) {
  HalfSpace west;
  west.normal = {1, 0, 0};
  Fault slip;
  slip.by = {0, 0, 2};
  const auto f = [&](const Fault& fault, const char* rho, const Vec3& p) {
    return value({fault, {{formula(rho)}, {west}}}, p);
  };
  Fault turn;
  turn.angle = 90;
  Fault both = turn;
  both.by = {0, 0, 2};
  expect("Paris 2019, 4.4: rho(w^-1(p)) strictly inside the domain x < 0, rho(p) elsewhere",
         {{f(slip, "z / 10", {1, 0, 5}), 0.5},
          {f(slip, "z / 10", {-1, 0, 5}), 0.3},
          {f(slip, "z / 10", {0.001, 0, 5}), 0.5},
          {f(slip, "z / 10", {-0.001, 0, 5}), 0.3},
          {f(slip, "x / 10", {-1, 0, 5}), -0.1},
          // (-2, 3) turned back by 90 degrees is (3, 2).
          {f(turn, "x / 10", {-2, 3, 0}), 0.3},
          {f(turn, "y / 10", {-2, 3, 0}), 0.2},
          {f(both, "z / 10", {-2, 3, 4}), 0.2},
          {f(both, "z / 10", {2, 3, 4}), 0.4}});
}

TEST(Equation, Fold) {
  Fold fold;
  fold.amplitude = 6;
  fold.wavelength = 40;
  fold.octaves = 2;
  fold.seed = 5;
  std::vector<Row> rows;
  for (const Vec3& p : {Vec3{0, 0, 0}, Vec3{13, -7, 22}, Vec3{-31, 4, 9}, Vec3{90, 80, -70}}) {
    const float zero = 0;
    float t = 0;
    turbulence(fold.noise(), p, {&zero, 1}, {&zero, 1}, {&zero, 1}, {&t, 1});
    const double moved = p.z + 6 * (2 * static_cast<double>(t) - 1);
    rows.push_back({value({fold, {{formula("z / 100")}}}, p), moved / 100, 1e-5});
    rows.push_back({value({fold, {{formula("x / 100")}}}, p), p.x / 100, 1e-5});
    rows.push_back(
        {value({fold, {{formula("z / 100")}, {formula("0.5")}}}, p), (p.z + moved) / 200, 1e-5});
  }
  expect("Paris 2019, 4.3 (mended): f(p + delta(p)), delta = a (2 t - 1) n f_D", rows);
}

TEST(Equation, TurbulenceRange) {
  // t is a mean of octaves in [0,1] with weights 2^-k: within [0,1] whatever their number.
  for (int octaves = 1; octaves <= 12; ++octaves) {
    float least = 2, most = -1;
    for (int i = 0; i < 4000; ++i) {
      const Vec3 p{1.37 * i, -0.91 * i, 0.53 * i};
      const float zero = 0;
      float t = 0;
      turbulence({10, octaves, 3}, p, {&zero, 1}, {&zero, 1}, {&zero, 1}, {&t, 1});
      least = std::min(least, t);
      most = std::max(most, t);
    }
    EXPECT_GE(least, 0.0F) << "Paris 2019, 3.3 (mended), octaves " << octaves;
    EXPECT_LE(most, 1.0F) << "Paris 2019, 3.3 (mended), octaves " << octaves;
    EXPECT_LT(least, 0.25F);
    EXPECT_GT(most, 0.75F);
  }
}

TEST(Equation, Morph) {
  const auto f = [](double amount) {
    Morph m;
    m.amount = amount;
    return value({m, {{formula("0.2")}, {formula("0.9")}}}, {1, 2, 3});
  };
  expect("Zawadzki 2013, III.E, equation 14: f (1 - a) + g a",
         {{f(0), 0.2}, {f(0.25), 0.375}, {f(0.5), 0.55}, {f(0.75), 0.725}, {f(1), 0.9}});
}

TEST(Equation, Distances) {
  const auto f = [](const Node& d, double k, const Vec3& p) {
    FromDistance field;
    field.falloff = k;
    return value({field, {d}}, p);
  };
  const Node sphere{ball({0, 0, 0}, 5, 4)};
  Offset grown;
  grown.by = 1;
  Shell wall;
  wall.wall = 2;
  DistanceUnion joined;
  joined.width = 2;
  // On the plane between them both are 3 away: 3 - 2 / 4.
  const Node pair{joined, {{ball({-4, 0, 0}, 1, 4)}, {ball({4, 0, 0}, 1, 4)}}};
  expect("DESIGN 3: F = clamp(1/2 - d/(2k)); offset, shell and union in metres",
         {{f(sphere, 2, {5, 0, 0}), 0.5},
          {f(sphere, 2, {4, 0, 0}), 0.75},
          {f(sphere, 2, {0, 6, 0}), 0.25},
          {f(sphere, 2, {3, 0, 0}), 1},
          {f(sphere, 2, {7.01, 0, 0}), 0},
          {f({grown, {sphere}}, 2, {6, 0, 0}), 0.5},
          {f({grown, {sphere}}, 2, {0, 0, 7}), 0.25},
          {f({wall, {sphere}}, 2, {6, 0, 0}), 0.5},
          {f({wall, {sphere}}, 2, {4, 0, 0}), 0.5},
          {f({wall, {sphere}}, 2, {5, 0, 0}), 0.75},
          {f({wall, {sphere}}, 2, {0, 0, 0}), 0},
          {f(pair, 5, {0, 0, 0}), 0.25},
          {f(pair, 5, {4, 0, 0}), 0.6}});
}

}  // namespace
}  // namespace hoodoo::tree
