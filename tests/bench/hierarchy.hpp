#pragma once
#include <array>
#include <vector>

#include "tests/bench/scene.hpp"

namespace hoodoo::bench {

/// A bounding-volume hierarchy asked point by point, as Paris et al. 2019 (section 7) evaluate a
/// construction tree.
class Hierarchy {
 public:
  explicit Hierarchy(std::vector<Ball> balls);
  float sum(float x, float y, float z) const;
  /// Lowest and highest z of the boxes of the balls whose boxes stand over (x, y), whole metres
  /// rounded outward, joined to `range`; whether there is one.
  bool join_bounds(float x, float y, std::array<int, 2>& range) const;

 private:
  struct Volume {
    float low[3], high[3];
    int left, right;  // volumes below; no children: -1
    int first, count;
  };
  int build(int first, int last);

  std::vector<Ball> balls_;
  std::vector<Volume> volumes_;
};

}  // namespace hoodoo::bench
