#pragma once
#include "engine/tree/evaluate.hpp"

namespace hoodoo::tree {

/// Value and gradient of a tree at one place.
struct Probe {
  double f = 0;
  Vec3 gradient;
};

inline Probe probe(const Node& tree, const Vec3& at) {
  const Compiled compiled = compile(tree, {at, Box{at, at}.grown(1)});
  if (!compiled.kernel) return {};
  const float zero = 0;
  float f = 0, x = 0, y = 0, z = 0;
  compiled.kernel->gradients({{&zero, 1}, {&zero, 1}, {&zero, 1}}, {&f, 1},
                             {{&x, 1}, {&y, 1}, {&z, 1}});
  return {static_cast<double>(f),
          {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}};
}

inline double value(const Node& tree, const Vec3& at) { return probe(tree, at).f; }

/// A ball about `center`, its field falling from 1 to 0 across `falloff`.
inline Sphere ball(const Vec3& center, double radius, double falloff, double energy = 1) {
  Sphere s;
  s.center = center;
  s.radius = radius;
  s.falloff = falloff;
  s.energy = energy;
  return s;
}

inline PointNode dot_at(const Vec3& center, double radius, double energy = 1) {
  PointNode p;
  p.center = center;
  p.radius = radius;
  p.energy = energy;
  return p;
}

}  // namespace hoodoo::tree
