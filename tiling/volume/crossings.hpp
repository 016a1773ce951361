#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/tree/field.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/volume/lanes.hpp"
#include "tiling/volume/relief.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::volume {

/// The surface is where the density has this value; solid is above.
inline constexpr double iso_value = 0.5;

/// Values of a block's points at 256 x + 16 y + z, as its own field has them.
using BlockValues = std::array<float, 4096>;

/// Finds where the surface crosses the marked edges of a volume, a block's in one batch.
class CrossingFinder {
 public:
  CrossingFinder(slice::Land& land, Volume& volume, ReliefColumns& columns);

  /// The crossings of block `b`. `known`, where it is not null, are the values of its points.
  void find(const Index& b, const BlockValues* known);
  /// Some crossings are there only after it.
  void finish() { relief_.finish(); }

 private:
  /// By its low end, from the block's corner.
  struct Edge {
    std::uint8_t x, y, z, axis;
    bool solid;              // the low end, and not the high one
    std::uint16_t crossing;  // its place in the block
  };
  using Ends = std::array<std::vector<double>, 2>;

  void gather_edges(const Block& block);
  void cross_field(Block& block, const tree::Field& field, const BlockValues* known);
  void find_ends(const tree::Field& field, const BlockValues* known);
  std::optional<double> disagreeing_end(std::size_t edge) const;
  void start_roots();
  void place_points(std::span<const std::uint32_t> edges, std::span<const double> at);
  void evaluate(const tree::Field& field);
  void finish(Block& block, const tree::Field& field);
  void set_materials(Block& block, const tree::Field& field);
  std::span<const std::uint32_t> all_edges();

  slice::Land& land_;
  Volume& volume_;
  double spacing_;
  ReliefCrossings relief_;
  // Of the block at hand:
  std::vector<Edge> edges_, listed_;
  std::vector<double> t_;  // of each edge
  Ends ends_;              // values there less the iso value
  RootLanes roots_;
  std::vector<std::uint32_t> chosen_;
  std::vector<float> x_, y_, z_, value_;
  std::array<std::vector<float>, 3> normal_;
  std::array<std::vector<double>, 3> uphill_;
  std::vector<double> above_;
  std::vector<int> material_;
};

}  // namespace hoodoo::volume
