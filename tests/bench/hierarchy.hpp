#pragma once
#include <vector>

#include "tests/bench/scene.hpp"

namespace hoodoo::bench {

/// A bounding-volume hierarchy asked point by point, as Paris et al. 2019 (section 7) evaluate a
/// construction tree.
class Hierarchy {
 public:
  explicit Hierarchy(std::vector<Ball> balls);
  float sum(float x, float y, float z) const;

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
