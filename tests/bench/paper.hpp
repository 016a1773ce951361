#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/bench/hierarchy.hpp"
#include "tests/bench/scene.hpp"

namespace hoodoo::bench {

/// Polygonises a scene as Paris et al. 2019 describe in section 7, scalar, one thread: bounds on
/// the surface's elevation in every column, from the elevation and a hierarchy of bounding volumes;
/// joined over each column's neighbours; the field asked point by point inside them; marching cubes
/// on the cells they leave. Crossings come straight from the elevations where no ball stands over
/// either column, else by bisection to 1e-4 of an edge. Elevations of columns are looked up once.
/// Vertices have no normals, as the paper's.
class Paper {
 public:
  explicit Paper(const Scene& scene);

  struct Result {
    std::size_t vertices = 0, triangles = 0;
    std::size_t calls = 0;    // of the field
    std::size_t covered = 0;  // columns with a ball over them
    double looking_up = 0;    // seconds of these for the columns' elevations
  };
  Result run();

 private:
  using Point = std::array<float, 3>;
  /// What a row of columns holds, between its bounds, and the vertices on the edges that leave each
  /// point in +x, +y and +z.
  struct Row {
    std::vector<std::size_t> first;  // of each column, less its lowest point
    std::vector<float> values;
    std::array<std::vector<std::uint32_t>, 3> vertex;
  };
  struct Bounds {
    int low, high;
  };

  std::size_t column(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(scene_.wide) +
           static_cast<std::size_t>(i);
  }
  float field(float x, float y, float z, float h);
  void look_up_elevations();
  void find_bounds();
  void dilate();
  void sample(int j, Row& row);
  void add_cells(int j);
  void add_cell(int i, int j, int k, unsigned mask);
  std::uint32_t vertex(int i, int j, int k, unsigned edge);
  float cross(int i, int j, int k, int axis, float low);

  const Scene& scene_;
  Hierarchy hierarchy_;
  std::vector<float> heights_;  // of the columns
  std::vector<Bounds> own_, dilated_;
  std::vector<bool> covered_;
  std::array<Row, 2> rows_;  // of the columns on either side of the cells at hand
  std::vector<Point> points_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::size_t vertices_ = 0;
  Result result_;
};

}  // namespace hoodoo::bench
