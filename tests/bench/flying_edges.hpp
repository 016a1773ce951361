#pragma once
#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace hoodoo::bench {

/// vtkFlyingEdges3D with normals on one thread, over values that stay in memory. Only where VTK is
/// there.
class FlyingEdges {
 public:
  FlyingEdges(std::vector<float>& values, const std::array<int, 3>& size);
  ~FlyingEdges();
  /// Triangles at iso value 0.
  std::size_t run();

 private:
  struct Pipeline;
  std::unique_ptr<Pipeline> pipeline_;
};

}  // namespace hoodoo::bench
