#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/hash.hpp"
#include "engine/base/vector.hpp"
#include "engine/tree/node_type.hpp"

namespace hoodoo::tree {

/// A point of the lattice that voxels stand on.
using Voxel = std::array<std::int32_t, 3>;

/// Least and greatest of some voxels, and whether any of them is unset.
struct VoxelRange {
  float low = std::numeric_limits<float>::infinity();
  float high = -std::numeric_limits<float>::infinity();
  bool gaps = false;

  bool any() const { return low <= high; }
  void add(float v);
  void add(const VoxelRange& r);
};

/// Immutable sparse voxels: a value on some points of an integer lattice, and the affine map from
/// the lattice to space. Copies share them.
///
/// A tree of three levels, as OpenVDB's (Museth 2013, VDB: High-Resolution Sparse Volumes with
/// Dynamic Topology): nodes of 32^3, of 16^3 and bricks of 8^3 voxels; a region of one value takes
/// one entry. Every node knows its range.
class Voxels {
 public:
  static constexpr int brick_side = 8;
  static constexpr std::size_t brick_size = 512;
  static constexpr float unset = std::numeric_limits<float>::quiet_NaN();
  static constexpr std::int32_t farthest_voxel = 1 << 29;

  /// Where lattice points lie: linear v + shift, in the file's units.
  struct Placement {
    Matrix linear{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Vec3 shift;
  };
  class Builder;
  class Cursor;

  Voxels() = default;
  bool empty() const { return !data_; }
  const Placement& placement() const { return data_->placement; }
  /// What the file has where no voxel is set.
  float background() const { return data_->background; }
  /// Around all that are set, both corners included.
  const Voxel& low() const { return data_->low; }
  const Voxel& high() const { return data_->high; }
  /// Of all that are set; gaps are always there, outside.
  const VoxelRange& range() const { return data_->range; }
  /// Of those in the box, both corners included; it may be wider where the box is large.
  VoxelRange range(const Voxel& from, const Voxel& to) const;
  /// Names the content: values, which are set, background and placement.
  const Digest& digest() const { return data_->digest; }

  friend bool operator==(const Voxels& a, const Voxels& b) {
    return a.data_ == b.data_ || (a.data_ && b.data_ && a.digest() == b.digest());
  }

 private:
  using Brick = std::array<float, brick_size>;  // x slowest
  /// A node of the level below, or one value throughout.
  struct Entry {
    std::int32_t child = -1;
    float value = unset;
  };
  struct Inner {
    VoxelRange range;
    std::vector<Entry> entries;  // x slowest
  };
  struct Data {
    Placement placement;
    float background = 0;
    Voxel low, high;
    VoxelRange range;
    Digest digest;
    std::map<Voxel, Entry> roots;             // by place / 4096
    std::array<std::vector<Inner>, 2> inner;  // of bricks; of those
    std::vector<std::unique_ptr<const Brick>> bricks;
    std::vector<VoxelRange> brick_ranges;
  };
  struct Walk;

  std::shared_ptr<const Data> data_;
};

/// Reads voxels one by one; remembers the brick it read last. The voxels outlive it.
class Voxels::Cursor {
 public:
  explicit Cursor(const Voxels& voxels) : data_(voxels.data_.get()) {}
  /// NaN where unset.
  float at(std::int32_t i, std::int32_t j, std::int32_t k);

 private:
  void find(const Voxel& brick);
  const Data* data_;
  Voxel place_{std::numeric_limits<std::int32_t>::max(), 0, 0};  // of the brick / 8
  const Brick* brick_ = nullptr;                                 // null: `value_` throughout
  float value_ = unset;
};

/// Makes voxels from finite values in any order. Whoever sets a place twice has the last value.
class Voxels::Builder {
 public:
  Builder() : data_(std::make_shared<Data>()) {}
  /// `values` of the brick whose lowest voxel is `from`, a multiple of 8; x slowest, NaN: unset.
  void brick(const Voxel& from, std::span<const float, brick_size> values);
  /// One value throughout a cube of 8, 128 or 4096 voxels (level 0, 1, 2) that starts at `from`, a
  /// multiple of its side.
  void tile(const Voxel& from, int level, float value);
  /// Leaves the builder empty. Empty voxels when none was set.
  Voxels finish(const Placement& placement, float background);

 private:
  struct Summary;
  Entry& entry(const Voxel& at, int level);
  std::shared_ptr<Data> data_;
};

}  // namespace hoodoo::tree
