#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/dem/window.hpp"
#include "engine/tree/field.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/volume/lanes.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::volume {

/// Values of a block's points at 256 x + 16 y + z, as its own field has them.
using BlockValues = std::array<float, 4096>;

/// Finds where the surface crosses the marked edges of a volume, a block's in one batch.
class CrossingFinder {
 public:
  CrossingFinder(slice::Land& land, Volume& volume);

  /// The crossings of block `b`. `known`, where it is not null, are the values of its points.
  void find(const Index& b, const BlockValues* known);

 private:
  struct Edge {
    Index low;
    int axis;
  };
  using Ends = std::array<std::vector<double>, 2>;

  void gather_edges(const Index& b);
  void cross_heights(const dem::Window& window);
  void cross_along_ground(const dem::Window& window, std::size_t count);
  void cross_field(const Index& b, const tree::Field& field, const BlockValues* known);
  void find_ends(const Index& b, const tree::Field& field, const BlockValues* known);
  std::optional<double> disagreeing_end(std::size_t edge) const;
  void start_roots(std::size_t count);
  template <class Evaluate>
  void find_roots(Evaluate evaluate);
  void place_points(const Index& b, std::span<const std::uint32_t> edges,
                    std::span<const double> at);
  void evaluate(const tree::Field& field);
  void finish(const Index& b, const tree::Field& field);
  void set_materials(const Index& b, const tree::Field& field);
  void put_normals(const std::array<std::span<const double>, 3>& uphill);
  std::span<const std::uint32_t> all_edges(std::size_t count);

  slice::Land& land_;
  Volume& volume_;
  double spacing_;
  // Of the block at hand:
  std::vector<Edge> edges_;
  std::vector<double> t_;  // of each edge
  Ends ends_;              // values there less the iso value
  RootLanes roots_;
  std::vector<std::uint32_t> chosen_;
  std::vector<float> x_, y_, z_, value_;
  std::array<std::vector<float>, 3> normal_;
  std::vector<double> px_, py_, h_, hx_, hy_, above_;
  std::vector<int> material_;
};

}  // namespace hoodoo::volume
