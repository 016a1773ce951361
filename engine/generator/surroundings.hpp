#pragma once
#include <cstdint>

#include "engine/generator/site.hpp"

namespace hoodoo::generator {

/// The scene so far around one place, for many small questions. Its answers depend on the box, the
/// scene and the place alone. One thread at a time.
class Surroundings {
 public:
  Surroundings(const Site& site, const Box& box)
      : box_(box), block_(site.compile(box)), site_(site) {}

  const Box& box() const { return box_; }
  const Site& site() const { return site_; }
  /// At a place of the box.
  Site::Value at(const Vec3& p) const;
  bool solid(const Vec3& p) const;
  bool covered(const Vec3& p) const { return site_.covered(block_.windows, p.x, p.y); }

 private:
  Box box_;
  Site::Block block_;
  const Site& site_;
};

/// What is drawn for a place, by its coordinates.
std::uint64_t key_of_place(std::uint64_t seed, const Vec3& p);

/// The level part of a normal at length 1; none where the surface is level.
inline Vec3 outward(const Vec3& normal) { return normalized({normal.x, normal.y, 0}, {}); }

}  // namespace hoodoo::generator
