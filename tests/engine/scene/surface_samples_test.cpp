#include "engine/generator/surface_samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/random.hpp"
#include "tests/engine/scene/growing.hpp"

namespace hoodoo::scene {
namespace {

using generator::SurfaceSample;
using Places = std::vector<std::array<double, 3>>;

/// The coast of the fixture with a ball that hangs over it.
class SurfaceSamples : public GrowingTest {
 protected:
  static constexpr double apart = 12;

  SurfaceSamples()
      : scene_(grown(with(nlohmann::json::parse(R"({"op": "union", "tree":
      {"type": "sphere", "center": [500, 500, 260], "radius": 60, "falloff": 30}})")))) {}

  std::vector<SurfaceSample> samples(const Box& box, int threads = 1, std::uint64_t seed = 1) {
    const generator::Site site(scene_.ground, scene_.pyramids, scene_.spacing, scene_.extent,
                               {threads});
    return sample_surface(site, {box, apart, seed, 1, {}, {}});
  }
  static Places places(const std::vector<SurfaceSample>& samples) {
    Places list;
    for (const auto& s : samples) list.push_back({s.at.x, s.at.y, s.at.z});
    return list;
  }

  Scene scene_;
  Box box_{{300, 300, -50}, {700, 700, 400}};
};

TEST_F(SurfaceSamples, LieOnTheSurfaceWithItsNormal) {
  const auto all = samples(box_);
  ASSERT_GT(all.size(), 500U);
  std::size_t hanging = 0;
  for (const auto& s : all) {
    EXPECT_TRUE(box_.contains(s.at));
    EXPECT_GT(field(scene_, s.at - s.normal * 2), 0.5F);
    EXPECT_LT(field(scene_, s.at + s.normal * 2), 0.5F);
    hanging += s.normal.z < -0.5 ? 1 : 0;
  }
  EXPECT_GT(hanging, 20U);  // the underside of the ball
}

TEST_F(SurfaceSamples, KeepTheirDistance) {
  const auto all = samples(box_);
  double nearest = 1e9;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      nearest = std::min(nearest, length(all[i].at - all[j].at));
    }
  }
  EXPECT_GE(nearest, apart);
  EXPECT_LT(nearest, 1.2 * apart);
}

// Darts on the ball: one that no sample is near would have found room.
TEST_F(SurfaceSamples, LeaveHardlyAnyRoom) {
  const auto all = samples(box_);
  int roomy = 0;
  constexpr int darts = 2000;
  for (int i = 0; i < darts; ++i) {
    const double z = 2 * unit_real(random_bits(5, i, 0)) - 1;
    const double turn = 2 * 3.14159265358979 * unit_real(random_bits(5, i, 1));
    const double r = std::sqrt(1 - z * z);
    const Vec3 p = Vec3{500, 500, 260} + Vec3{r * std::cos(turn), r * std::sin(turn), z} * 60;
    const auto distance = [&](const SurfaceSample& s) { return length(s.at - p); };
    roomy += distance(std::ranges::min(all, {}, distance)) > 1.1 * apart ? 1 : 0;
  }
  EXPECT_LT(roomy, darts / 25);
}

TEST_F(SurfaceSamples, AreTheSameForAnyBoxAndThreads) {
  auto all = places(samples(box_));
  EXPECT_EQ(all, places(samples(box_, 2)));
  EXPECT_NE(all, places(samples(box_, 1, 2)));
  Places parts;
  for (const double x : {300.0, 500.0}) {
    for (const double y : {300.0, 433.0}) {
      const Box part{{x, y, -50}, {x == 300 ? 500.0 : 700.0, y == 300 ? 433.0 : 700.0, 400}};
      const auto some = places(samples(part));
      parts.insert(parts.end(), some.begin(), some.end());
    }
  }
  std::ranges::sort(all);
  std::ranges::sort(parts);
  EXPECT_EQ(all, parts);
}

}  // namespace
}  // namespace hoodoo::scene
