#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/dem/window.hpp"
#include "tiling/volume/lanes.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::volume {

/// Elevations over the points of a block column and over those beside it in +x and +y, and unit
/// normals of the ground there, by axis: column (x, y) of points at 17 y + x.
struct ReliefColumn {
  static constexpr std::size_t side = 17;
  const dem::Window* window = nullptr;  // whose elevations they are
  std::array<double, side * side> h;
  std::array<std::array<float, side * side>, 3> normal;
};

/// Those of a volume, each looked up when it is first asked for: a block's signs and its crossings
/// come from the same elevations.
class ReliefColumns {
 public:
  ReliefColumns(const Volume& volume, double spacing);
  const ReliefColumn& at(std::int64_t x, std::int64_t y, const dem::Window& window);

 private:
  void look_up(std::int64_t x, std::int64_t y, ReliefColumn& column) const;

  double spacing_;
  std::array<std::int64_t, 2> low_;
  std::size_t wide_;
  std::vector<std::unique_ptr<ReliefColumn>> columns_;
};

/// Crossings of blocks that elevations alone govern. On a vertical edge the crossing is h itself;
/// level ones of many blocks are found together.
/// Source: Paris et al. 2019, section 7, direct elevation extraction.
class ReliefCrossings {
 public:
  ReliefCrossings(double spacing, ReliefColumns& columns) : spacing_(spacing), columns_(columns) {}

  /// Those of block `b`: of vertical edges at once, of level ones by the next `finish`.
  void find(const Index& b, Block& block, const dem::Window& window);
  void finish();

 private:
  static constexpr std::size_t side = ReliefColumn::side, enough = 1024;
  /// Level edges that wait, in the order of t_.
  struct Edges {
    std::vector<Crossing*> crossing;
    std::vector<double> x, y, z;  // low end [m]
    std::vector<std::uint8_t> axis;
  };

  void cross_upright(const Index& b, Block& block, const ReliefColumn& column) const;
  void wait(const Index& b, Block& block, const ReliefColumn& column);
  void find_roots();
  void place(std::size_t edge, double t, std::size_t to);

  double spacing_;
  ReliefColumns& columns_;
  // Of the edges that wait.
  const dem::Window* window_ = nullptr;
  Edges edges_;
  std::array<std::vector<double>, 2> ends_;  // elevations there less z
  std::vector<std::uint32_t> open_;
  RootLanes roots_;
  std::vector<double> t_, px_, py_, above_, sx_, sy_;
  std::array<std::vector<float>, 3> out_;
};

}  // namespace hoodoo::volume
