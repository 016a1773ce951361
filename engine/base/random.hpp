#pragma once
#include <cstdint>

namespace hoodoo {

/// Counter-based randomness: a pure function of its arguments, so that nothing depends on the
/// order of visits. Mixing after Stafford's variant 13 of the SplitMix64 finaliser (Steele, Lea,
/// Flood 2014, Fast Splittable Pseudorandom Number Generators).
inline std::uint64_t mix(std::uint64_t v) {
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9U;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebU;
  return v ^ (v >> 31);
}

template <class... More>
std::uint64_t random_bits(std::uint64_t first, More... more) {
  std::uint64_t h = mix(first + 0x9e3779b97f4a7c15U);
  ((h = mix(h ^ (static_cast<std::uint64_t>(more) + 0x9e3779b97f4a7c15U))), ...);
  return h;
}

/// Uniform in [0, 1).
inline double unit_real(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * (1.0 / 9007199254740992.0);
}

}  // namespace hoodoo
