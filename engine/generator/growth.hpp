#pragma once
#include <cstdint>
#include <memory>
#include <string_view>

#include "engine/generator/record.hpp"
#include "engine/generator/site.hpp"
#include "engine/tree/region.hpp"

namespace hoodoo::generator {

/// One generator at work: where it may ask, and where it leaves what it made.
struct Growth {
  Site& site;
  Record& record;
  std::uint64_t seed;                          // of the scene, the operation and the generator
  std::shared_ptr<const tree::Region> region;  // null: everywhere
  int material = -1;                           // of the operation

  /// Where it may act: the region inside the world [m]; z as far as surfaces of the scene go.
  Box reach() const;
  /// How much it may act at a place, in [0, 1].
  double weight(const Vec3& p) const { return region ? region->weight(p).w : 1; }
  /// Queues a tree; from then on the site has it. It acts everywhere, or in a region of its own.
  void add(tree::Operation operation, tree::Node tree,
           std::shared_ptr<const tree::Region> where = nullptr);
};

/// Most primitives of one generator.
inline constexpr std::size_t most_primitives = 5'000'000;
/// Errors: limit, naming what there are too many of.
void expect_few(std::size_t count, std::size_t most, std::string_view what);

}  // namespace hoodoo::generator
