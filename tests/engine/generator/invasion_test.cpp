#include "engine/generator/invasion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine/base/error.hpp"
#include "engine/base/random.hpp"

namespace hoodoo::generator {
namespace {

constexpr std::size_t plenty = 100'000;

/// Ground at z = 0 over a plain without end; rho by place.
InvadedRock plain(const std::function<double(const Vec3&)>& rho) {
  return {[rho](std::span<const Vec3> at, std::span<float> out) {
            for (std::size_t i = 0; i < at.size(); ++i) out[i] = static_cast<float>(rho(at[i]));
          },
          [](const Vec3& p) { return -p.z; }};
}

/// Rough rock without a direction.
double rough(const Vec3& p) {
  const auto cell = [](double v) { return static_cast<std::int64_t>(std::floor(v / 7)); };
  return 0.6 * unit_real(random_bits(9, cell(p.x), cell(p.y), cell(p.z)));
}

InvasionRules rules() {
  InvasionRules rules;
  rules.step = 4;
  rules.exclusion = 5;
  rules.count = 300;
  rules.upward = 0.3;
  return rules;
}

TEST(Invasion, TakesTheLeastResistantFirstAndOfEqualOnesTheFirst) {
  const std::vector<Vec3> starts{{0, 0, -20}, {100, 0, -20}, {200, 0, -20}, {300, 0, -20}};
  const double rho[] = {0.4, 0.1, 0.3, 0.1};
  auto only_starts = rules();
  only_starts.epsilon = 0;
  only_starts.length = 1;
  const auto made = invade(
      starts, only_starts,
      plain([&](const Vec3& p) { return rho[static_cast<std::size_t>(p.x / 100)]; }), plenty);
  ASSERT_EQ(made.passages.size(), 4u);
  const std::uint32_t order[] = {1, 3, 2, 0};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(made.passages[i].start, order[i]) << i;
}

/// Invasion percolation by the letter: looks through all candidates for the least.
std::vector<Vec3> by_the_letter(const Vec3& start, const InvasionRules& rules) {
  struct One {
    Vec3 at;
    float rho;
    bool waits;
  };
  std::vector<One> all{{start, static_cast<float>(rough(start)), true}};
  std::vector<Vec3> carved;
  while (carved.size() < rules.count) {
    std::size_t least = all.size();
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all[i].waits && (least == all.size() || all[i].rho < all[least].rho)) least = i;
    }
    if (least == all.size()) break;
    all[least].waits = false;
    carved.push_back(all[least].at);
    for (int k = 1; k <= rules.directions; ++k) {
      const auto bits = candidate_bits(rules.seed, start, static_cast<std::uint32_t>(least), k);
      const Vec3 p = all[least].at + rules.step * direction_below(bits, rules.upward);
      bool free = -p.z >= rules.cover && -p.z <= rules.depth &&
                  static_cast<float>(rough(p)) < static_cast<float>(rules.rho_0);
      for (std::size_t i = 0; i < all.size(); ++i) {
        free = free && (i == least || length(all[i].at - p) >= rules.exclusion);
      }
      if (free) all.push_back({p, static_cast<float>(rough(p)), true});
    }
  }
  return carved;
}

TEST(Invasion, WithoutChanceIsTheDeterministicOneInExactOrder) {
  auto exact = rules();
  exact.epsilon = 0;
  exact.length = 1e5;
  const Vec3 start{3, 4, -60};
  const auto made = invade({&start, 1}, exact, plain(rough), plenty);
  const auto expected = by_the_letter(start, exact);
  ASSERT_GT(expected.size(), 100u);
  ASSERT_EQ(made.passages.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(made.passages[i].at, expected[i]) << i;
}

TEST(Invasion, GoesDownOrLevelUnlessItMayRise) {
  auto falling = rules();
  falling.upward = 0;
  const Vec3 start{0, 0, -30};
  const auto made = invade({&start, 1}, falling, plain(rough), plenty);
  ASSERT_GT(made.passages.size(), 20u);
  for (const auto& one : made.passages) {
    if (one.parent == Passage::none) continue;
    EXPECT_LE(one.at.z, made.passages[one.parent].at.z);
  }
  double most = -1;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const Vec3 d = direction_below(mix(i), 0.25);
    EXPECT_NEAR(length(d), 1, 1e-12);
    most = std::max(most, d.z);
  }
  EXPECT_LE(most, 0.25);
  EXPECT_GT(most, 0.2);
}

TEST(Invasion, KeepsPassagesApartButForTheOneBefore) {
  const std::vector<Vec3> starts{{0, 0, -30}, {20, 0, -30}};
  const auto made = invade(starts, rules(), plain(rough), plenty);
  const auto& all = made.passages;
  ASSERT_GT(all.size(), 100u);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (all[i].parent == j) continue;
      EXPECT_GE(length(all[i].at - all[j].at), 5) << i << " " << j;
    }
  }
}

TEST(Invasion, StaysInsideItsLimits) {
  auto limited = rules();
  limited.depth = 50;
  limited.length = 60;
  limited.count = 80;
  limited.cover = 10;
  limited.upward = 1;
  const std::vector<Vec3> starts{{0, 0, 0}, {500, 0, 0}};
  const auto made = invade(starts, limited, plain([](const Vec3&) { return 0.2; }), plenty);
  std::vector<std::size_t> count(2);
  for (const auto& one : made.passages) {
    ++count[one.start];
    EXPECT_LE(-one.at.z, 50);
    EXPECT_LE(one.length, 60);
    EXPECT_LT(one.resistance, 0.5F);
    // The entrance leads down; under the cover nothing comes up again.
    if (one.parent == Passage::none || -one.at.z >= 10) continue;
    EXPECT_LE(one.at.z, made.passages[one.parent].at.z - 2);
  }
  EXPECT_EQ(count, (std::vector<std::size_t>{80, 80}));
  EXPECT_THROW(invade(starts, limited, plain([](const Vec3&) { return 0.2; }), 50), Error);
}

TEST(Invasion, EndsPathsAtAResurgence) {
  auto drained = rules();
  drained.resurgences = {{80, 0, -40}};
  drained.pull = 2;
  drained.count = 2000;
  const Vec3 start{0, 0, -30};
  const auto made = invade({&start, 1}, drained, plain([](const Vec3&) { return 0.2; }), plenty);
  const auto& all = made.passages;
  std::size_t end = all.size();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].at == drained.resurgences[0]) end = i;
  }
  ASSERT_LT(end, all.size());
  for (const auto& one : all) EXPECT_NE(one.parent, end);
  for (const auto& [from, to] : made.joins) EXPECT_EQ(to, end);
}

TEST(Invasion, OfOneStartDoesNotDependOnAnotherOneFarAway) {
  const std::vector<Vec3> both{{5000, 0, -30}, {0, 0, -30}};
  const auto alone = invade(std::span(both).subspan(1), rules(), plain(rough), plenty);
  const auto made = invade(both, rules(), plain(rough), plenty);
  std::vector<Vec3> own;
  for (const auto& one : made.passages) {
    if (one.start == 1) own.push_back(one.at);
  }
  ASSERT_EQ(own.size(), alone.passages.size());
  for (std::size_t i = 0; i < own.size(); ++i) EXPECT_EQ(own[i], alone.passages[i].at);
}

TEST(Invasion, OfAnotherSeedIsAnother) {
  const Vec3 start{0, 0, -30};
  auto other = rules();
  other.seed = 1;
  const auto a = invade({&start, 1}, rules(), plain(rough), plenty);
  const auto b = invade({&start, 1}, other, plain(rough), plenty);
  ASSERT_GT(std::min(a.passages.size(), b.passages.size()), 10u);
  EXPECT_NE(a.passages[5].at, b.passages[5].at);
}

}  // namespace
}  // namespace hoodoo::generator
