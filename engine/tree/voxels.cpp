#include "engine/tree/voxels.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hoodoo::tree {
namespace {

constexpr int brick_bits = 3;
constexpr std::array<int, 2> entry_bits{3, 7};  // side of an inner node's entry
constexpr std::array<int, 2> fan_bits{4, 5};    // entries along its side
constexpr int root_bits = 12;                   // side of a root's entry
constexpr std::int32_t exact_side = 32;         // boxes up to so wide are read voxel by voxel

Voxel divided(const Voxel& v, int bits) { return {v[0] >> bits, v[1] >> bits, v[2] >> bits}; }
Voxel multiplied(const Voxel& v, int bits) {
  return {v[0] * (1 << bits), v[1] * (1 << bits), v[2] * (1 << bits)};
}

/// Place of a voxel's entry in an inner node.
std::size_t slot(const Voxel& v, int level) {
  const auto l = static_cast<std::size_t>(level);
  const int bits = fan_bits[l], mask = (1 << bits) - 1;
  const Voxel e = divided(v, entry_bits[l]);
  return static_cast<std::size_t>(((e[0] & mask) << bits | (e[1] & mask)) << bits | (e[2] & mask));
}

/// Place of a voxel in its brick.
std::size_t place_in_brick(const Voxel& v) {
  return static_cast<std::size_t>((v[0] & 7) << 6 | (v[1] & 7) << 3 | (v[2] & 7));
}

/// The lowest voxel of an entry of a node that starts at `from`.
Voxel start_of(const Voxel& from, int level, std::size_t entry) {
  const auto l = static_cast<std::size_t>(level);
  const int bits = fan_bits[l];
  const auto n = static_cast<std::int32_t>(entry), mask = (1 << bits) - 1;
  return {from[0] + ((n >> 2 * bits) << entry_bits[l]),
          from[1] + ((n >> bits & mask) << entry_bits[l]), from[2] + ((n & mask) << entry_bits[l])};
}

}  // namespace

void VoxelRange::add(float v) {
  if (std::isnan(v)) {
    gaps = true;
  } else {
    low = std::min(low, v);
    high = std::max(high, v);
  }
}

void VoxelRange::add(const VoxelRange& r) {
  low = std::min(low, r.low);
  high = std::max(high, r.high);
  gaps = gaps || r.gaps;
}

float Voxels::Cursor::at(std::int32_t i, std::int32_t j, std::int32_t k) {
  const Voxel v{i, j, k};
  const Voxel brick = divided(v, brick_bits);
  if (brick != place_) find(brick);
  return brick_ != nullptr ? (*brick_)[place_in_brick(v)] : value_;
}

void Voxels::Cursor::find(const Voxel& brick) {
  place_ = brick;
  brick_ = nullptr;
  value_ = unset;
  const auto root = data_->roots.find(divided(brick, root_bits - brick_bits));
  if (root == data_->roots.end()) return;
  const Voxel v = multiplied(brick, brick_bits);
  const Entry* entry = &root->second;
  for (int level = 1; level >= 0 && entry->child >= 0; --level) {
    const auto& nodes = data_->inner[static_cast<std::size_t>(level)];
    entry = &nodes[static_cast<std::size_t>(entry->child)].entries[slot(v, level)];
  }
  if (entry->child >= 0) {
    brick_ = data_->bricks[static_cast<std::size_t>(entry->child)].get();
  } else {
    value_ = entry->value;
  }
}

/// Recursion through the levels; level -1 are the bricks.
struct Voxels::Walk {
  const Data& data;
  Voxel from, to;  // both included
  bool exact;      // bricks voxel by voxel
  VoxelRange found{};

  /// An entry that stands for the cube of 2^bits voxels from `start`.
  void entry(const Entry& e, const Voxel& start, int bits, int level) {
    const std::int32_t last = (1 << bits) - 1;
    bool whole = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (start[axis] > to[axis] || start[axis] + last < from[axis]) return;
      whole = whole && start[axis] >= from[axis] && start[axis] + last <= to[axis];
    }
    if (e.child < 0) return found.add(e.value);
    const auto child = static_cast<std::size_t>(e.child);
    if (level < 0) return brick(child, start, whole);
    const Inner& node = data.inner[static_cast<std::size_t>(level)][child];
    if (whole) return found.add(node.range);
    const int below = entry_bits[static_cast<std::size_t>(level)];
    for (std::size_t i = 0; i < node.entries.size(); ++i) {
      entry(node.entries[i], start_of(start, level, i), below, level - 1);
    }
  }

  void brick(std::size_t child, const Voxel& start, bool whole) {
    if (whole || !exact) return found.add(data.brick_ranges[child]);
    const auto low = [&](std::size_t axis) { return std::max(start[axis], from[axis]); };
    const auto high = [&](std::size_t axis) { return std::min(start[axis] + 7, to[axis]); };
    const Brick& values = *data.bricks[child];
    for (std::int32_t i = low(0); i <= high(0); ++i) {
      for (std::int32_t j = low(1); j <= high(1); ++j) {
        for (std::int32_t k = low(2); k <= high(2); ++k) {
          found.add(values[place_in_brick({i, j, k})]);
        }
      }
    }
  }
};

VoxelRange Voxels::range(const Voxel& from, const Voxel& to) const {
  const auto length = [&](std::size_t axis) { return std::int64_t{to[axis]} - from[axis] + 1; };
  bool small = true;
  std::uint64_t cells = 1;  // of the root that the box touches
  for (std::size_t axis = 0; axis < 3; ++axis) {
    small = small && length(axis) <= exact_side;
    cells *= static_cast<std::uint64_t>((to[axis] >> root_bits) - (from[axis] >> root_bits) + 1);
  }
  Walk walk{*data_, from, to, small};
  std::uint64_t met = 0;
  for (const auto& [place, entry] : data_->roots) {
    bool near = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      near = near && place[axis] >= from[axis] >> root_bits && place[axis] <= to[axis] >> root_bits;
    }
    if (!near) continue;
    ++met;
    walk.entry(entry, multiplied(place, root_bits), root_bits, 1);
  }
  walk.found.gaps = walk.found.gaps || met < cells;
  return walk.found;
}

Voxels::Entry& Voxels::Builder::entry(const Voxel& at, int level) {
  Entry* e = &data_->roots[divided(at, root_bits)];
  for (int l = 1; l >= level; --l) {
    auto& nodes = data_->inner[static_cast<std::size_t>(l)];
    if (e->child < 0) {
      const auto count = std::size_t{1} << 3 * fan_bits[static_cast<std::size_t>(l)];
      const auto made = static_cast<std::int32_t>(nodes.size());
      nodes.push_back({{}, std::vector<Entry>(count, Entry{-1, e->value})});
      e->child = made;
    }
    e = &nodes[static_cast<std::size_t>(e->child)].entries[slot(at, l)];
  }
  return *e;
}

void Voxels::Builder::brick(const Voxel& from, std::span<const float, brick_size> values) {
  auto brick = std::make_unique<Brick>();
  std::copy(values.begin(), values.end(), brick->begin());
  VoxelRange range;
  for (float& v : *brick) {
    if (std::isnan(v)) v = unset;  // one NaN, for the digest
    range.add(v);
  }
  if (!range.any()) return;
  entry(from, 0) = {static_cast<std::int32_t>(data_->bricks.size()), unset};
  data_->bricks.push_back(std::move(brick));
  data_->brick_ranges.push_back(range);
}

void Voxels::Builder::tile(const Voxel& from, int level, float value) {
  entry(from, level) = {-1, value};
}

/// Finds the box, the ranges and the digest of what was built. Goes entry by entry in the order of
/// their places, so that the digest does not depend on the order in which they came.
struct Voxels::Builder::Summary {
  Data& data;
  Sha256 content{};

  template <class T>
  void name(const T& v) {
    content.add(std::as_bytes(std::span(&v, 1)));
  }

  VoxelRange entry(const Entry& e, const Voxel& start, int bits, int level) {
    if (e.child < 0) return tile(e.value, start, bits);
    const auto child = static_cast<std::size_t>(e.child);
    if (level < 0) return brick(child, start);
    Inner& node = data.inner[static_cast<std::size_t>(level)][child];
    for (std::size_t i = 0; i < node.entries.size(); ++i) {
      node.range.add(entry(node.entries[i], start_of(start, level, i),
                           entry_bits[static_cast<std::size_t>(level)], level - 1));
    }
    return node.range;
  }

 private:
  VoxelRange tile(float value, const Voxel& start, int bits) {
    VoxelRange range;
    range.add(value);
    if (!range.any()) return range;
    name(std::array{start[0], start[1], start[2], bits, 0});
    name(value);
    enclose(start, (1 << bits) - 1);
    return range;
  }

  VoxelRange brick(std::size_t child, const Voxel& start) {
    const Brick& values = *data.bricks[child];
    name(std::array{start[0], start[1], start[2], brick_bits, 1});
    name(values);
    for (std::int32_t n = 0; n < static_cast<std::int32_t>(brick_size); ++n) {
      if (std::isnan(values[static_cast<std::size_t>(n)])) continue;
      enclose({start[0] + (n >> 6), start[1] + (n >> 3 & 7), start[2] + (n & 7)}, 0);
    }
    return data.brick_ranges[child];
  }

  void enclose(const Voxel& from, std::int32_t last) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      data.low[axis] = std::min(data.low[axis], from[axis]);
      data.high[axis] = std::max(data.high[axis], from[axis] + last);
    }
  }
};

Voxels Voxels::Builder::finish(const Placement& placement, float background) {
  const auto data = std::exchange(data_, std::make_shared<Data>());
  data->placement = placement;
  data->background = background;
  constexpr std::int32_t most = std::numeric_limits<std::int32_t>::max();
  data->low = {most, most, most};
  data->high = {-most, -most, -most};
  Summary summary{*data};
  summary.name(placement.linear);
  summary.name(std::array{placement.shift.x, placement.shift.y, placement.shift.z});
  summary.name(background);
  for (const auto& [place, entry] : data->roots) {
    data->range.add(summary.entry(entry, multiplied(place, root_bits), root_bits, 1));
  }
  data->range.gaps = true;
  data->digest = summary.content.finish();
  Voxels made;
  if (data->range.any()) made.data_ = data;
  return made;
}

}  // namespace hoodoo::tree
