#include "engine/tree/region.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

namespace hoodoo::tree {
namespace {

TEST(Region, FallsFromOneToZeroAcrossItsFeather) {
  Region r;
  r.box.min.z = 10;
  r.feather = 4;
  EXPECT_EQ(r.weight({0, 0, 12}).w, 1);
  EXPECT_EQ(r.weight({0, 0, 8}).w, 0);
  EXPECT_DOUBLE_EQ(r.weight({0, 0, 10}).w, 0.5);
  // u = 1/2: (1 + (1.5 - 0.125) / 2) / 2 = 0.84375.
  EXPECT_DOUBLE_EQ(r.weight({0, 0, 11}).w, 0.84375);
  EXPECT_DOUBLE_EQ(r.weight({0, 0, 10}).gradient.z, 1.5 / 4);
}

TEST(Region, IsHardWithoutAFeather) {
  Region r;
  r.polygon = {{0, 0}, {10, 0}, {0, 10}};
  EXPECT_EQ(r.weight({1, 1, 500}).w, 1);
  EXPECT_EQ(r.weight({-0.001, 1, 0}).w, 0);
  EXPECT_EQ(r.weight({6, 6, 0}).w, 0);
}

TEST(Region, ReadsAMaskAtItsSampleCentres) {
  Region r;
  r.mask = {0, 0, 4, 2, 2, 1, {0.25F, 0.75F}};
  EXPECT_DOUBLE_EQ(r.weight({1, 1, 0}).w, 0.25);
  EXPECT_DOUBLE_EQ(r.weight({2, 1, 9}).w, 0.5);
  EXPECT_DOUBLE_EQ(r.weight({2, 1, 9}).gradient.x, 0.25);
  EXPECT_DOUBLE_EQ(r.weight({3.9, 0.1, 0}).w, 0.75);
  EXPECT_EQ(r.weight({4.1, 1, 0}).w, 0);
}

class AnyRegion : public testing::TestWithParam<int> {
 protected:
  static Region region() {
    Region r;
    r.feather = 3;
    if (GetParam() == 0) r.box = {{-5, -4, -6}, {6, 3, 4}};
    if (GetParam() == 1) r.polygon = {{-6, -5}, {7, -4}, {2, 1}, {4, 8}};
    if (GetParam() == 2) r.mask = {-6, -6, 7, 5, 3, 3, {0, 1, 0.5F, 1, 1, 0, 0.2F, 0.9F, 1}};
    return r;
  }
};

TEST_P(AnyRegion, HasTheGradientOfItsWeight) {
  const Region r = region();
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> any(-9, 9);
  int kinks = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p{any(engine), any(engine), any(engine)};
    const Weight w = r.weight(p);
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 step;
      step[axis] = 1e-5;
      const double slope = (r.weight(p + step).w - r.weight(p - step).w) / 2e-5;
      kinks += std::abs(slope - w.gradient[axis]) > 1e-4;
    }
  }
  EXPECT_LE(kinks, 5);
}

TEST_P(AnyRegion, ContainsItsWeightsOverABox) {
  const Region r = region();
  std::mt19937 engine(2);
  std::uniform_real_distribution<double> any(-9, 9), part(0, 1);
  for (int i = 0; i < 300; ++i) {
    const Vec3 low{any(engine), any(engine), any(engine)}, size{part(engine) * 4, 3, 2};
    const Interval w = r.weights({low, low + size});
    for (int k = 0; k < 30; ++k) {
      const Vec3 p =
          low + Vec3{size.x * part(engine), size.y * part(engine), size.z * part(engine)};
      EXPECT_TRUE(w.contains(r.weight(p).w));
      if (!r.influence().contains(p)) {
        EXPECT_EQ(r.weight(p).w, 0);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(BoxPolygonMask, AnyRegion, testing::Range(0, 3));

TEST(Region, IsNamedInCanonicalFormByAllThatMatters) {
  Region r;
  r.box.max.z = 5;
  const auto json = to_json(r);
  EXPECT_TRUE(json["box"]["min"][0].is_null());
  EXPECT_EQ(json["box"]["max"][2], 5);
  Region painted = r;
  painted.mask = {0, 0, 1, 1, 1, 1, {0.5F}};
  Region repainted = painted;
  repainted.mask.weights[0] = 0.6F;
  EXPECT_NE(to_json(painted), to_json(repainted));
}

}  // namespace
}  // namespace hoodoo::tree
