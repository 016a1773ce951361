#include "tiling/volume/ready_grid.hpp"

#include <cmath>

#include "tests/bench/measure.hpp"
#include "tests/bench/surface.hpp"
#include "tiling/surface/surface.hpp"

#ifdef HOODOO_BENCH_VTK
#include "tests/bench/flying_edges.hpp"
#endif

namespace hoodoo::bench {
namespace {

constexpr int side = 256;

/// A wavy ball, solid above 0: about 0.4 million triangles.
std::vector<float> wavy_ball() {
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(side) * side * side);
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const double dx = x - 127.3, dy = y - 127.6, dz = z - 127.4;
        const double waves = std::sin(0.11 * x) * std::sin(0.13 * y) * std::sin(0.12 * z);
        values.push_back(
            static_cast<float>(100 + 12 * waves - std::sqrt(dx * dx + dy * dy + dz * dz)));
      }
    }
  }
  return values;
}

}  // namespace

void compare_ready_grid() {
  auto values = wavy_ball();
  const std::array<int, 3> size{side, side, side};
  std::size_t ours = 0, theirs = 0;
  volume::Volume volume;
  surface::Workspace workspace;
  const auto extract = [&] {
    volume::read({values, size, 0}, volume);
    ours = surface::polygonize(volume, 256, workspace).triangles.size();
  };
#ifdef HOODOO_BENCH_VTK
  FlyingEdges edges(values, size);
  const auto [seconds, vtk_seconds] = median_seconds(extract, [&] { theirs = edges.run(); });
#else
  const auto [seconds, vtk_seconds] = median_seconds(extract, [] {});
#endif
  fmt::print("a grid of {0}^3 floats in memory\n", side);
  fmt::print("  {:56} {:9.1f} ms, {} triangles\n", "signs, Hermite data, dual contouring",
             1e3 * seconds, ours);
  if (theirs == 0) {
    fmt::print("  VTK is not there to compare with\n");
    return;
  }
  fmt::print("  {:56} {:9.1f} ms, {} triangles\n", "vtkFlyingEdges3D with normals",
             1e3 * vtk_seconds, theirs);
  ratio("ready grid: ours / vtkFlyingEdges3D", seconds / vtk_seconds, "<= 1");
}

}  // namespace hoodoo::bench
