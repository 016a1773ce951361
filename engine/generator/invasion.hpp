#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/vector.hpp"

namespace hoodoo::generator {

/// How an invasion spreads. Every limit is of one start.
struct InvasionRules {
  double rho_0 = 0.5;    // rock of this resistance and more is left alone
  double epsilon = 0.1;  // how much chance there is in the order
  int directions = 8;    // tried from every passage
  double upward = 0;     // greatest upward part of a direction, in [0, 1]
  double step = 4;       // to a candidate [m]
  double exclusion = 4;  // least distance of a candidate to all but its parent [m]
  double cover = 8;      // least depth away from entrances [m]
  double depth = 200;    // greatest [m]
  double length = 500;   // of a path from its start [m]
  std::uint32_t count = 1000;
  std::vector<Vec3> resurgences{};
  double pull = 0.5;
  std::uint64_t seed = 0;
};

/// The rock that is invaded.
struct InvadedRock {
  std::function<void(std::span<const Vec3>, std::span<float>)> resistances;  // rho
  std::function<double(const Vec3&)> depth;  // below the surface [m]; NaN where nothing may grow
};

/// Why a candidate was left out.
enum class Refusal { crowded, outside, deep, shallow, hard, far, many };
inline constexpr std::array<std::string_view, 7> refusal_names = {
    "crowded out", "outside", "too deep", "under too little cover",
    "too hard",    "too far", "too many",
};

struct Passage {
  static constexpr std::uint32_t none = 0xffffffffU;
  Vec3 at;
  std::uint32_t parent;  // a passage before it; none at a start
  std::uint32_t start;
  double length;  // of the path from the start [m]
  float resistance;
};

struct Invasion {
  std::vector<Passage> passages;  // in the order in which they were carved
  std::vector<std::pair<std::uint32_t, std::uint32_t>> joins;  // that end where another path ends
  std::array<std::uint64_t, refusal_names.size()> refused{};
  std::vector<Refusal> start_refusals;  // of the starts that are none
  std::uint64_t candidates = 0;
};

/// A unit direction whose part upward is at most `upward`, evenly over that part of the sphere.
Vec3 direction_below(std::uint64_t bits, double upward);

/// Candidate number `number` of a start is perturbed by these bits; k counts its directions from 1.
std::uint64_t candidate_bits(std::uint64_t seed, const Vec3& start, std::uint32_t number, int k);

/// Invasion percolation from several starts with one queue: takes the candidate of least
/// rho (1 + epsilon u), u uniform in [0, 1), makes it a passage, and queues new candidates a step
/// from it, until none is left. Equal ones go by start, then by number within the start.
///
/// A candidate needs rock softer than `rho_0`, no other candidate or passage but its parent nearer
/// than `exclusion`, and its place within the limits. A path that has reached the cover stays under
/// it; until then each step leads deeper by half a step at least. Near a resurgence less cover
/// does; a passage within a step of one is joined to it, and its path ends.
///
/// What grows from a start depends on other starts through the exclusion alone. At most `most`
/// passages: Errors: limit.
/// Source: Paris et al. 2019, section 6.2; Wilkinson, Willemsen 1983, Invasion percolation.
Invasion invade(std::span<const Vec3> starts, const InvasionRules& rules, const InvadedRock& rock,
                std::size_t most);

}  // namespace hoodoo::generator
