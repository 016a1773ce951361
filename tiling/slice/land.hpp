#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "engine/dem/window.hpp"
#include "engine/tree/field.hpp"
#include "tiling/slice/slice.hpp"

namespace hoodoo::slice {

/// Index of a world-anchored block of 16^3 cells at the slice's level.
struct BlockIndex {
  std::int64_t x, y, z;
  friend bool operator==(const BlockIndex&, const BlockIndex&) = default;
};
inline constexpr int block_cells = 16;

/// A point in steps of the slice's level, counted from the scene origin.
using StepPoint = std::array<std::int64_t, 3>;

/// A slice opened for evaluation: elevations in memory, one field per block, compiled when first
/// asked for. The block that owns a point (half-open) answers for it, whoever asks.
/// Covers the tile and one block around it. For one thread.
class Land {
 public:
  Land(const Slice& slice, std::span<const std::shared_ptr<const dem::Pyramid>> pyramids);

  const Slice& slice() const { return slice_; }
  const tree::Field& field(const BlockIndex& block);
  /// The cell column [i, i+1) x [j, j+1) of the lattice lies in the world: its centre is inside
  /// the extent and over a valid sample of some body.
  bool in_world(std::int64_t i, std::int64_t j) const;
  /// That of columns (i + p, j + q) into out[wide q + p].
  void in_world(std::int64_t i, std::int64_t j, std::size_t wide,
                std::span<std::uint8_t> out) const;
  /// Walls and a floor close the world, so that solid ends below the ground, too.
  bool is_closed() const { return slice_.floor.has_value(); }
  /// Lowest and highest z [m] that can hold the ground's surface over `area`; empty (low > high) if
  /// none.
  Interval heights(const Box& area) const;
  /// Lowest and highest elevation [m] of the bodies at (x, y); empty (low > high) if none.
  Interval heights_at(double x, double y) const;

  Vec3 metres(const StepPoint& p) const;
  BlockIndex owner(const StepPoint& p) const;

  /// Unit outward normals at `points`, by their owners' gradients; +z where there is none.
  std::vector<Vec3f> normals(std::span<const StepPoint> points);
  /// Newton's step [m] from each point, counted from `origin`, towards the surface F = 1/2, by
  /// their owners' fields; zero where there is no gradient. Points of one block should come
  /// together.
  struct Moves {
    std::vector<double> x, y, z;
  };
  void steps_to_surface(const StepPoint& origin,
                        std::span<const std::array<std::int32_t, 3>> points, Moves& out);
  /// rho in [0,1] at `points`.
  std::vector<float> resistances(std::span<const StepPoint> points);
  /// F at `points`.
  std::vector<float> values(std::span<const StepPoint> points);
  /// Points at which `steps_to_surface`, `normals` and `values` have asked a field for F.
  std::uint64_t evaluations() const { return evaluations_; }

 private:
  std::unique_ptr<const tree::Field> closed_at(const BlockIndex& block, const Vec3& origin,
                                               std::unique_ptr<const tree::Field> field) const;

  /// Points next to each other that one block owns.
  struct Run {
    BlockIndex block;
    std::size_t from, to;
  };
  std::vector<Run> runs_of(std::span<const StepPoint> points) const;
  template <class Visit>
  void by_owner(std::span<const StepPoint> points, Visit visit);

  using Offsets = std::span<const std::array<std::int32_t, 3>>;
  void steps_to_ground(const dem::Window& window, const StepPoint& origin, Offsets points,
                       std::size_t to, Moves& out) const;
  void steps_in_block(const BlockIndex& block, const StepPoint& origin, Offsets points,
                      std::size_t to, Moves& out);

  struct BlockHash {
    std::size_t operator()(const BlockIndex& b) const;
  };
  const Slice& slice_;
  std::vector<dem::Window> windows_;
  std::unordered_map<BlockIndex, std::unique_ptr<const tree::Field>, BlockHash> fields_;
  std::uint64_t evaluations_ = 0;
};

}  // namespace hoodoo::slice
