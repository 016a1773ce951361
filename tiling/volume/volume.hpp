#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "engine/base/vector.hpp"

namespace hoodoo::slice {
class Land;
}

/// tiling/volume: Slice -> Hermite blocks: solid or air per grid point, crossings per edge.
namespace hoodoo::volume {

/// A lattice point or cell (by its low corner), in cells from the scene origin.
using Index = std::array<std::int64_t, 3>;

/// Of 16 bits, those that are set. std::popcount is a call on the baseline processor.
constexpr std::size_t count_bits(unsigned bits) {
  bits -= bits >> 1 & 0x5555;
  bits = (bits & 0x3333) + (bits >> 2 & 0x3333);
  bits = (bits + (bits >> 4)) & 0x0f0f;
  return (bits + (bits >> 8)) & 0x1f;
}

/// Where the surface crosses one lattice edge.
struct Crossing {
  float t = 0.5F;              // from the low end, in [0, 1] edges
  Vec3f normal{0, 0, 1};       // unit, out of the solid
  std::uint16_t material = 0;  // of the solid end
};

/// 16^3 lattice points and the edges that leave them in +x, +y, +z. Rows run along x, one bit per
/// point: row = 16 z + y.
struct Block {
  static constexpr int side = 16;
  std::array<std::uint16_t, 256> solid{};
  std::array<std::array<std::uint16_t, 256>, 3> crossed{};  // by axis
  std::array<std::array<std::uint16_t, 256>, 3> first{};    // crossings before the row
  std::vector<Crossing> crossings;

  /// That of the edge along `axis` from point x of a row; it is crossed.
  const Crossing& crossing(std::size_t axis, std::size_t row, unsigned x) const {
    return crossings[first[axis][row] + count_bits(crossed[axis][row] & ((1U << x) - 1))];
  }
  /// Calls visit(row) for the rows with a crossed edge along `axis`, in order.
  template <class Visit>
  void for_each_row(std::size_t axis, Visit visit) const {
    for (std::size_t four = 0; four < 256; four += 4) {
      std::uint64_t any = 0;  // most rows have none
      std::memcpy(&any, &crossed[axis][four], sizeof any);
      if (any == 0) continue;
      for (std::size_t row = four; row < four + 4; ++row) {
        if (crossed[axis][row] != 0) visit(row);
      }
    }
  }
};

/// The lattice of one tile: points of the closed box [low, high], edges between them, and which
/// cell columns are meshed. Blocks of one kind of point throughout are not stored.
class Volume {
 public:
  /// Empty until it is reset.
  Volume() = default;
  /// Everything air, every column in the world.
  Volume(const Index& low, const Index& high) { reset(low, high); }
  /// As if made anew, in the memory that it has.
  void reset(const Index& low, const Index& high);

  const Index& low() const { return low_; }
  const Index& high() const { return high_; }

  /// Column (i, j) of cells lies in the world. Known for the box and one column around it, so that
  /// boxes that share a face treat the world's edge beside it alike.
  bool in_world(std::int64_t i, std::int64_t j) const { return in_world_[column(i, j)] != 0; }
  void set_in_world(std::int64_t i, std::int64_t j, bool in_world) {
    in_world_[column(i, j)] = in_world ? 1 : 0;
  }
  /// All of them: those of the box and one column around it, 0 or 1, i fastest.
  std::span<std::uint8_t> in_world() { return in_world_; }
  /// Cells of column (i, j) are part of the surface: it lies in the box and in the world.
  bool meshed(std::int64_t i, std::int64_t j) const {
    return i >= low_[0] && j >= low_[1] && i < high_[0] && j < high_[1] && in_world(i, j);
  }

  bool solid(const Index& p) const {
    const auto& b = slots_[slot(p)];
    return b.block ? (b.block->solid[row(p)] >> (p[0] & 15) & 1) != 0 : b.solid;
  }
  /// The edge from `p` along `axis` is crossed: its ends differ and a meshed cell touches it.
  /// True only after `mark`.
  bool crossed(int axis, const Index& p) const {
    const auto& b = slots_[slot(p)].block;
    return b && (b->crossed[static_cast<std::size_t>(axis)][row(p)] >> (p[0] & 15) & 1) != 0;
  }
  Crossing& crossing(int axis, const Index& p) {
    return const_cast<Crossing&>(std::as_const(*this).crossing(axis, p));
  }
  const Crossing& crossing(int axis, const Index& p) const {
    return slots_[slot(p)].block->crossing(static_cast<std::size_t>(axis), row(p),
                                           static_cast<unsigned>(p[0] & 15));
  }

  /// Block indices covered, low inclusive, high exclusive; block b holds points [16 b, 16 b + 16).
  const Index& block_low() const { return block_low_; }
  const Index& block_high() const { return block_high_; }
  /// The stored block, or null where all its points are alike.
  const Block* block(const Index& b) const { return slots_[slot_of_block(b)].block.get(); }
  bool uniform_solid(const Index& b) const { return slots_[slot_of_block(b)].solid; }

  /// meshed(16 x + i, 16 y + j) of block column (x, y) for i and j from -1 to 15: bit i + 1 of
  /// entry j + 1. After `mark`.
  using MeshedRows = std::array<std::uint32_t, 17>;
  const MeshedRows& meshed_rows(std::int64_t x, std::int64_t y) const {
    return meshed_[static_cast<std::size_t>((y - block_low_[1]) * size_[0] + x - block_low_[0])];
  }

  /// The signs of a block's points and of those beside it in +x, +y, +z: bit x of rows[z][y]; 0
  /// beyond what is covered.
  using Rows = std::array<std::array<std::uint32_t, 17>, 17>;
  void read_rows(const Index& b, Rows& rows) const;

  /// Points at which the field was asked for what is known here.
  std::uint64_t evaluations() const { return evaluations_; }
  void add_evaluations(std::size_t n) { evaluations_ += n; }

  void set_uniform(const Index& b, bool solid);
  /// A stored block for `b`, all air at first; points are set through its bits.
  Block& make_block(const Index& b);
  void set_solid(const Index& p, bool solid);

  /// Finds the crossed edges from the signs, and makes room for their crossings, which are to be
  /// set. Blocks without
  /// a mixture of points that still own a crossed edge become stored ones.
  void mark();
  /// Calls visit(axis, Index) for every crossed edge, blocks in order (z, y, x), within a block by
  /// axis, then in the order of its crossings.
  template <class Visit>
  void for_each_crossing(Visit visit) const;

 private:
  struct Slot {
    std::unique_ptr<Block> block;
    bool solid = false;
  };
  std::size_t slot_of_block(const Index& b) const {
    return static_cast<std::size_t>(((b[2] - block_low_[2]) * size_[1] + (b[1] - block_low_[1])) *
                                        size_[0] +
                                    (b[0] - block_low_[0]));
  }
  std::size_t slot(const Index& p) const {
    return slot_of_block({p[0] >> 4, p[1] >> 4, p[2] >> 4});
  }
  static std::size_t row(const Index& p) {
    return static_cast<std::size_t>((p[2] & 15) * 16 + (p[1] & 15));
  }
  std::size_t column(std::int64_t i, std::int64_t j) const {
    return static_cast<std::size_t>((j - low_[1] + 1) * (high_[0] - low_[0] + 2) +
                                    (i - low_[0] + 1));
  }
  void find_meshed();
  bool may_be_crossed(const Index& b) const;
  void mark_block(const Index& b);

  Index low_{}, high_{}, block_low_{}, block_high_{}, size_{};
  std::vector<std::uint8_t> in_world_;
  std::vector<MeshedRows> meshed_;  // by block column
  std::vector<Slot> slots_;
  std::vector<std::unique_ptr<Block>> spare_;  // stored once, to be overwritten
  std::uint64_t evaluations_ = 0;
};

template <class Visit>
void Volume::for_each_crossing(Visit visit) const {
  for (std::int64_t z = block_low_[2]; z < block_high_[2]; ++z) {
    for (std::int64_t y = block_low_[1]; y < block_high_[1]; ++y) {
      for (std::int64_t x = block_low_[0]; x < block_high_[0]; ++x) {
        const Block* b = block({x, y, z});
        if (b == nullptr) continue;
        for (int axis = 0; axis < 3; ++axis) {
          for (int r = 0; r < 256; ++r) {
            auto bits = b->crossed[static_cast<std::size_t>(axis)][static_cast<std::size_t>(r)];
            for (; bits != 0; bits = static_cast<std::uint16_t>(bits & (bits - 1))) {
              visit(axis,
                    Index{16 * x + std::countr_zero(bits), 16 * y + (r & 15), 16 * z + (r >> 4)});
            }
          }
        }
      }
    }
  }
}

/// Samples the field of one tile: signs at the lattice points, crossings by bracketed root finding
/// to 1e-4 of an edge and their normals, by the block that owns the edge's low end; where
/// elevations alone govern a block, crossings come straight from them (Paris et al. 2019, section
/// 7). Uniform blocks (root interval excludes 1/2) are not sampled.
Volume sample(slice::Land& land);
/// The same in the memory of `volume`.
void sample(slice::Land& land, Volume& volume);

}  // namespace hoodoo::volume
