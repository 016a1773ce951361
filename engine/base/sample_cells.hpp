#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/base/random.hpp"
#include "engine/base/vector.hpp"

/// Where the samples of sampler.hpp lie, found again by place.
namespace hoodoo::sampling {

/// A cell of a lattice; z is 0 in the plane.
struct Cell {
  std::int32_t x = 0, y = 0, z = 0;
};

inline std::int32_t floor_of(double v) {
  const auto whole = static_cast<std::int32_t>(v);
  return whole - static_cast<std::int32_t>(static_cast<double>(whole) > v);
}
template <bool flat>
Cell cell_at(const Vec3& p, double per_side) {
  return {floor_of(p.x * per_side), floor_of(p.y * per_side), flat ? 0 : floor_of(p.z * per_side)};
}

/// The cells from `low` to `high`.
template <bool flat, class Visit>
void for_each_cell(const Cell& low, const Cell& high, Visit visit) {
  for (std::int32_t z = flat ? 0 : low.z; z <= (flat ? 0 : high.z); ++z) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      for (std::int32_t x = low.x; x <= high.x; ++x) visit(Cell{x, y, z});
    }
  }
}

inline constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

/// One number per cell of an endless lattice, held in blocks of 64 cells where one was set.
template <bool flat>
class Cells {
 public:
  /// `none` where nothing was set.
  std::uint32_t get(const Cell& c) const {
    const auto block = find(c);
    return block == none ? none : values_[std::size_t{block} * 64 + place_of(c)];
  }
  void set(const Cell& c, std::uint32_t value) {
    auto block = find(c);
    if (block == none) block = add(c);
    values_[std::size_t{block} * 64 + place_of(c)] = value;
  }

 private:
  static constexpr int shift = flat ? 3 : 2;
  static constexpr std::int32_t mask = (1 << shift) - 1;
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t block = none;
  };

  static std::uint64_t key_of(const Cell& c) {
    const auto bits = [](std::int32_t v) {
      return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v >> shift));
    };
    if (flat) return bits(c.x) << 32 | bits(c.y);
    return (bits(c.x) & 0x1fffff) << 42 | (bits(c.y) & 0x1fffff) << 21 | (bits(c.z) & 0x1fffff);
  }
  static std::size_t place_of(const Cell& c) {
    const std::int32_t z = flat ? 0 : c.z & mask;
    return static_cast<std::size_t>((z << 2 * shift) + ((c.y & mask) << shift) + (c.x & mask));
  }
  std::uint32_t find(const Cell& c) const {
    const auto key = key_of(c);
    if (last_.block != none && last_.key == key) return last_.block;
    const auto& slot = slots_[slot_of(key)];
    if (slot.block != none) last_ = slot;
    return slot.block;
  }
  /// Where the key stands, or where it would.
  std::size_t slot_of(std::uint64_t key) const {
    auto at = mix(key) & (slots_.size() - 1);
    while (slots_[at].block != none && slots_[at].key != key) at = (at + 1) & (slots_.size() - 1);
    return at;
  }
  std::uint32_t add(const Cell& c) {
    const auto block = static_cast<std::uint32_t>(values_.size() / 64);
    if (2 * std::size_t{block} >= slots_.size()) {
      std::vector<Slot> old(2 * slots_.size());
      old.swap(slots_);
      for (const auto& slot : old) {
        if (slot.block != none) slots_[slot_of(slot.key)] = slot;
      }
    }
    values_.resize(values_.size() + 64, none);
    const auto key = key_of(c);
    last_ = slots_[slot_of(key)] = {key, block};
    return block;
  }

  std::vector<Slot> slots_ = std::vector<Slot>(64);
  std::vector<std::uint32_t> values_;
  mutable Slot last_;
};

struct Sample {
  Vec3 center;
  double radius = 0;
  std::uint64_t id = 0;
};

inline double squared(double v) { return v * v; }
inline bool conflict(const Sample& s, const Vec3& p, double radius) {
  return squared(s.center.x - p.x) + squared(s.center.y - p.y) + squared(s.center.z - p.z) <
         squared(s.radius + radius);
}

/// Samples by place and size: those of a half to all of the largest radius in cells twice as wide
/// as that, those of a quarter to a half in cells half as wide, and so on.
template <bool flat>
class Samples {
 public:
  Samples(double radius_least, double radius_most) {
    for (double radius = radius_most;; radius /= 2) {
      sizes_.push_back({radius, 1 / (2 * radius), true, {}});
      if (radius / 2 < radius_least) break;
    }
  }
  const std::vector<Sample>& all() const { return all_; }
  std::size_t sizes() const { return sizes_.size(); }
  std::size_t size_of(double radius) const {
    std::size_t size = 0;
    while (size + 1 < sizes_.size() && radius <= sizes_[size + 1].radius) ++size;
    return size;
  }

  void add(const Sample& sample) {
    auto& size = sizes_[size_of(sample.radius)];
    size.empty = false;
    const auto cell = cell_at<flat>(sample.center, size.per_side);
    before_.push_back(size.cells.get(cell));
    size.cells.set(cell, static_cast<std::uint32_t>(all_.size()));
    all_.push_back(sample);
  }

  /// Visits the numbers of samples that may lie within `reach` and their own radius of a point,
  /// until one makes `visit` true; whether one did. `visit` may add samples elsewhere.
  template <class Visit>
  bool any_near(const Vec3& p, double reach, Visit visit) const {
    bool found = false;
    for (const auto& size : sizes_) {
      if (size.empty) continue;
      const double r = reach + size.radius;
      const Vec3 by = flat ? Vec3{r, r, 0} : Vec3{r, r, r};
      for_each_cell<flat>(cell_at<flat>(p - by, size.per_side),
                          cell_at<flat>(p + by, size.per_side), [&](const Cell& cell) {
                            if (found) return;
                            for (auto s = size.cells.get(cell); !found && s != none;
                                 s = before_[s]) {
                              found = visit(s);
                            }
                          });
      if (found) break;
    }
    return found;
  }

 private:
  struct Size {
    double radius, per_side;  // the largest; one over the side of a cell
    bool empty;
    Cells<flat> cells;  // the last sample of each
  };
  std::vector<Sample> all_;
  std::vector<std::uint32_t> before_;  // in the same cell
  std::vector<Size> sizes_;
};

}  // namespace hoodoo::sampling
