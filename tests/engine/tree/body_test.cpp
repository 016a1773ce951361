// The implicit height field (Paris et al. 2019, section 5.1, as DESIGN section 3 normalises it).
#include "engine/tree/body.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hoodoo::tree {
namespace {

/// Elevations 100 + x / 4, 1 m per pixel, over [-20, 20]^2.
dem::Window slope() {
  std::vector<float> samples;
  for (int j = 0; j < 40; ++j) {
    for (int i = 0; i < 40; ++i) samples.push_back(100 + (static_cast<float>(i) - 19.5F) / 4);
  }
  return dem::Window(-20, -20, 1, 1, 0, 0, 40, 40, samples);
}

struct Value {
  double f;
  Vec3 gradient;
};

Value at(const HeightBody& body, const dem::Window& window, const Vec3& p) {
  const Vec3 origin{-4, -4, 96};
  const BodyField field(body, window, {origin, {origin, origin + Vec3{30, 30, 30}}});
  const Vec3 d = p - origin;
  const auto x = static_cast<float>(d.x), y = static_cast<float>(d.y), z = static_cast<float>(d.z);
  float f = 0, gx = 0, gy = 0, gz = 0;
  field.gradients({{&x, 1}, {&y, 1}, {&z, 1}}, {&f, 1}, {{&gx, 1}, {&gy, 1}, {&gz, 1}});
  EXPECT_TRUE(outward(field.bounds()).contains(static_cast<double>(f)));
  return {static_cast<double>(f),
          {static_cast<double>(gx), static_cast<double>(gy), static_cast<double>(gz)}};
}

HeightBody body(double falloff) { return {"land", falloff, false, false, 0, {}}; }

TEST(HeightBody, IsOneHalfAtTheElevationAndRisesAcrossItsFalloff) {
  const auto window = slope();
  // h(4, 3) = 101. R = 8: u = 1/2 is (1 + (3/2 - 1/8) / 2) / 2 = 0.84375.
  EXPECT_NEAR(at(body(8), window, {4, 3, 101}).f, 0.5, 1e-6);
  EXPECT_NEAR(at(body(8), window, {4, 3, 97}).f, 0.84375, 1e-6);
  EXPECT_NEAR(at(body(8), window, {4, 3, 105}).f, 0.15625, 1e-6);
  EXPECT_EQ(at(body(4), window, {4, 3, 97}).f, 1);
  EXPECT_EQ(at(body(4), window, {4, 3, 105}).f, 0);
}

TEST(HeightBody, HasASlopeOfThreeQuartersPerFalloffAtItsSurface) {
  const Vec3 g = at(body(8), slope(), {4, 3, 101}).gradient;
  EXPECT_NEAR(g.z, -0.75 / 8, 1e-6);
  EXPECT_NEAR(g.x, 0.25 * 0.75 / 8, 1e-6);
  EXPECT_NEAR(g.y, 0, 1e-6);
}

TEST(HeightBody, IsMonotoneInHeight) {
  const auto window = slope();
  double before = 2;
  for (double z = 96; z < 120; z += 0.25) {
    const double f = at(body(6), window, {0, 0, z}).f;
    EXPECT_LE(f, before);
    before = f;
  }
}

TEST(HeightBody, DividesByTheSlopeWhenAsked) {
  HeightBody corrected = body(8);
  corrected.slope_corrected = true;
  const double u = 4 / std::sqrt(1 + 1.0 / 16) / 8;
  EXPECT_NEAR(at(corrected, slope(), {4, 3, 97}).f, 0.5 + 0.25 * (3 * u - u * u * u), 1e-6);
  EXPECT_NEAR(at(corrected, slope(), {4, 3, 101}).f, 0.5, 1e-6);
}

TEST(HeightBody, IsSolidAboveWhenInvertedAndMovesByItsOffset) {
  HeightBody other = body(8);
  other.inverted = true;
  other.offset = 2;
  EXPECT_NEAR(at(other, slope(), {4, 3, 103}).f, 0.5, 1e-6);
  EXPECT_NEAR(at(other, slope(), {4, 3, 107}).f, 0.84375, 1e-6);
}

TEST(HeightBody, IsCutByThePrismOfItsDomain) {
  HeightBody cut = body(8);
  cut.domain = {{-10, -10}, {10, -10}, {10, 10}, {-10, 10}};
  const auto window = slope();
  EXPECT_NEAR(at(cut, window, {10, 3, 98}).f, 0.5, 1e-6);  // on the wall, under the ground
  EXPECT_NEAR(at(cut, window, {14, 3, 96}).f, 0.15625, 1e-6);
  EXPECT_NEAR(at(cut, window, {4, 3, 101}).f, 0.5, 1e-6);  // on the ground, inside
  EXPECT_NEAR(at(cut, window, {10, 3, 98}).gradient.x, -0.75 / 8, 1e-6);
  EXPECT_EQ(at(cut, window, {19, 3, 98}).f, 0);
}

TEST(HeightBody, GivesItsElevationsOnlyWhereTheyDecide) {
  const auto window = slope();
  const auto elevations = [&](const HeightBody& b, const Box& box) {
    return BodyField(b, window, {box.min, box}).elevations();
  };
  const Box middle{{0, 0, 98}, {2, 2, 104}};
  EXPECT_EQ(elevations(body(4), middle), &window);
  HeightBody other = body(4);
  other.domain = {{-10, -10}, {10, -10}, {10, 10}, {-10, 10}};
  EXPECT_EQ(elevations(other, middle), &window);  // the domain's edge is far
  EXPECT_EQ(elevations(other, {{4, 0, 98}, {8, 2, 104}}), nullptr);
  other = body(4);
  other.inverted = true;
  EXPECT_EQ(elevations(other, middle), nullptr);
  other = body(4);
  other.offset = 1;
  EXPECT_EQ(elevations(other, middle), nullptr);
}

}  // namespace
}  // namespace hoodoo::tree
