#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/dem/dem.hpp"
#include "engine/hydrology/grid.hpp"
#include "engine/tree/field.hpp"
#include "engine/tree/ground.hpp"

namespace hoodoo::generator {

/// Elevations of the input terrains on a square lattice of the scene frame; rows go north.
struct Elevations {
  double x0 = 0, y0 = 0, pixel = 1;  // south-west corner of cell (0, 0), side of a cell [m]
  hydrology::Grid grid;

  double x(std::int32_t i) const { return x0 + (i + 0.5) * pixel; }
  double y(std::int32_t j) const { return y0 + (j + 0.5) * pixel; }
  /// The cell that holds a place; nothing outside.
  std::optional<std::size_t> cell(double px, double py) const;
  /// Bilinear between the centres of cells; cells that are NaN are left out. 0 where all are.
  double between(std::span<const float> values, double px, double py) const;
};

/// What may be spent.
struct Spend {
  int threads = 1;
  std::size_t memory = std::size_t{256} << 20;  // [bytes] of rasters
  std::stop_token stop{};
};

/// The scene so far as generators see it: field, resistance and elevations, each by windows. All
/// answers depend on the scene and on the place alone, not on the order or number of questions.
class Site {
 public:
  /// All outlive the site; `ground` grows while generators run. `extent` is the world's, with the
  /// heights of its elevations [m]; `spacing` is s_0 [m].
  Site(tree::Ground& ground, std::span<const std::shared_ptr<const dem::Pyramid>> pyramids,
       double spacing, const Box& extent, Spend spend);

  const tree::Ground& ground() const { return ground_; }
  double spacing() const { return spacing_; }
  const Box& extent() const { return extent_; }
  /// All that the upright terrains cover; z is their heights [m].
  Box terrain_extent() const;
  /// The smallest pixel of the terrains that stand upright [m].
  double pixel() const { return pixel_; }
  const Spend& spend() const { return spend_; }
  void add(tree::Step step) { ground_.steps.push_back(std::move(step)); }

  struct Value {
    float field;       // F
    Vec3 gradient;     // of F [1/m]
    float resistance;  // rho
  };
  std::vector<Value> values(std::span<const Vec3> at) const;
  std::vector<float> resistances(std::span<const Vec3> at) const;

  /// A field for points of `box`, relative to its least corner. It refers to `windows`.
  struct Block {
    std::vector<dem::Window> windows;
    std::unique_ptr<const tree::Field> field;
  };
  Block compile(const Box& box) const;
  /// The same from windows that hold `box` already.
  std::unique_ptr<const tree::Field> compile(const Box& box,
                                             std::span<const dem::Window> windows) const;
  std::vector<dem::Window> windows(const Box& area) const;

  /// Elevations of the upright terrains over whole cells that hold `area` (x and y), anchored at
  /// the frame's origin; NaN where no terrain has any. The first terrain that has one wins.
  /// Errors: limit, where it takes more than the memory allows at `bytes_per_cell`.
  Elevations elevations(const Box& area, double pixel, std::size_t bytes_per_cell = 16) const;
  /// The z between which the input terrains lie over `area`.
  std::optional<Interval> heights(const Box& area) const;
  /// A terrain has an elevation here.
  bool covered(std::span<const dem::Window> windows, double x, double y) const;

  /// Calls `work(i)` for i below `count` on the site's threads. Errors: cancelled.
  void in_parallel(std::size_t count, const std::function<void(std::size_t)>& work) const;

 private:
  template <class Ask>
  void by_blocks(std::span<const Vec3> at, const Ask& ask) const;
  void fill_row(const Elevations& into, std::int32_t j, std::span<const double> x,
                std::span<const dem::Window> windows, float* out) const;

  tree::Ground& ground_;
  std::span<const std::shared_ptr<const dem::Pyramid>> pyramids_;
  double spacing_;
  Box extent_;
  Spend spend_;
  double pixel_;
};

}  // namespace hoodoo::generator
