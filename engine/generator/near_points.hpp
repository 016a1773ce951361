#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/base/random.hpp"
#include "engine/base/vector.hpp"

namespace hoodoo::generator {

/// Points, numbered as they are added, that are asked for by ball. A hash table of cubic cells,
/// each a chain of its points.
class NearPoints {
 public:
  /// `side` of a cell [m]: about the radius of the balls.
  explicit NearPoints(double side) : side_(side), slots_(64, Slot{0, none}) {}

  const std::vector<Vec3>& points() const { return points_; }

  void add(const Vec3& p) {
    if (2 * (used_ + 1) > slots_.size()) grow();
    const auto own = key(cell(p.x), cell(p.y), cell(p.z));
    auto& slot = slots_[find(slots_, own)];
    slot.key = own;
    used_ += slot.head == none ? 1 : 0;
    next_.push_back(slot.head);
    slot.head = static_cast<std::uint32_t>(points_.size());
    points_.push_back(p);
  }

  /// Calls visit(number) for every point no farther than `radius` from `p`.
  template <class Visit>
  void visit(const Vec3& p, double radius, const Visit& visit) const {
    for (auto z = cell(p.z - radius); z <= cell(p.z + radius); ++z) {
      for (auto y = cell(p.y - radius); y <= cell(p.y + radius); ++y) {
        for (auto x = cell(p.x - radius); x <= cell(p.x + radius); ++x) {
          for (auto i = slots_[find(slots_, key(x, y, z))].head; i != none; i = next_[i]) {
            const Vec3 d = points_[i] - p;
            // Cells far apart may share a key: a point counts in its own cell only.
            if (dot(d, d) <= radius * radius && cell(points_[i].x) == x &&
                cell(points_[i].y) == y && cell(points_[i].z) == z) {
              visit(i);
            }
          }
        }
      }
    }
  }

 private:
  static constexpr std::uint32_t none = 0xffffffffU;
  struct Slot {
    std::uint64_t key;
    std::uint32_t head;
  };

  std::int64_t cell(double v) const { return static_cast<std::int64_t>(std::floor(v / side_)); }
  static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
    const auto bits = [](std::int64_t v) { return static_cast<std::uint64_t>(v) & 0x1fffffU; };
    return bits(x) | bits(y) << 21U | bits(z) << 42U;
  }
  /// Where a key is, or where it would go.
  static std::size_t find(const std::vector<Slot>& slots, std::uint64_t key) {
    auto at = mix(key) & (slots.size() - 1);
    while (slots[at].head != none && slots[at].key != key) at = (at + 1) & (slots.size() - 1);
    return at;
  }
  void grow() {
    std::vector<Slot> larger(2 * slots_.size(), Slot{0, none});
    for (const auto& slot : slots_) {
      if (slot.head != none) larger[find(larger, slot.key)] = slot;
    }
    slots_ = std::move(larger);
  }

  double side_;
  std::vector<Slot> slots_;
  std::size_t used_ = 0;
  std::vector<Vec3> points_;
  std::vector<std::uint32_t> next_;
};

}  // namespace hoodoo::generator
