#include "tests/bench/hierarchy.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hoodoo::bench {

Hierarchy::Hierarchy(std::vector<Ball> balls) : balls_(std::move(balls)) {
  build(0, static_cast<int>(balls_.size()));
}

int Hierarchy::build(int first, int last) {
  Volume v{{1e30F, 1e30F, 1e30F}, {-1e30F, -1e30F, -1e30F}, -1, -1, first, last - first};
  for (int i = first; i < last; ++i) {
    const Ball& b = balls_[static_cast<std::size_t>(i)];
    const float centre[3] = {b.x, b.y, b.z};
    for (int a = 0; a < 3; ++a) {
      v.low[a] = std::min(v.low[a], centre[a] - b.reach);
      v.high[a] = std::max(v.high[a], centre[a] + b.reach);
    }
  }
  const auto id = volumes_.size();
  volumes_.push_back(v);
  if (last - first > 4) {
    int axis = 0;
    for (int a = 1; a < 3; ++a) {
      if (v.high[a] - v.low[a] > v.high[axis] - v.low[axis]) axis = a;
    }
    const int middle = (first + last) / 2;
    const auto key = [axis](const Ball& b) { return axis == 0 ? b.x : axis == 1 ? b.y : b.z; };
    std::nth_element(balls_.begin() + first, balls_.begin() + middle, balls_.begin() + last,
                     [&](const Ball& a, const Ball& b) { return key(a) < key(b); });
    const int left = build(first, middle), right = build(middle, last);
    volumes_[id].left = left;
    volumes_[id].right = right;
    volumes_[id].count = 0;
  }
  return static_cast<int>(id);
}

float Hierarchy::sum(float x, float y, float z) const {
  int open[64], size = 0;
  open[size++] = 0;
  float sum = 0;
  while (size > 0) {
    const Volume& v = volumes_[static_cast<std::size_t>(open[--size])];
    if (x < v.low[0] || y < v.low[1] || z < v.low[2] || x > v.high[0] || y > v.high[1] ||
        z > v.high[2]) {
      continue;
    }
    for (int i = v.first; i < v.first + v.count; ++i) {
      const Ball& b = balls_[static_cast<std::size_t>(i)];
      const float dx = x - b.x, dy = y - b.y, dz = z - b.z;
      const float q = 1 - (dx * dx + dy * dy + dz * dz) / (b.reach * b.reach);
      if (q > 0) sum += b.energy * q * q * q;
    }
    if (v.left < 0) continue;
    open[size++] = v.left;
    open[size++] = v.right;
  }
  return sum;
}

bool Hierarchy::join_bounds(float x, float y, std::array<int, 2>& range) const {
  int open[64], size = 0;
  open[size++] = 0;
  bool any = false;
  while (size > 0) {
    const Volume& v = volumes_[static_cast<std::size_t>(open[--size])];
    if (x < v.low[0] || y < v.low[1] || x > v.high[0] || y > v.high[1]) continue;
    for (int i = v.first; i < v.first + v.count; ++i) {
      const Ball& b = balls_[static_cast<std::size_t>(i)];
      if (std::abs(x - b.x) > b.reach || std::abs(y - b.y) > b.reach) continue;
      range[0] = std::min(range[0], static_cast<int>(std::floor(b.z - b.reach)));
      range[1] = std::max(range[1], static_cast<int>(std::ceil(b.z + b.reach)));
      any = true;
    }
    if (v.left < 0) continue;
    open[size++] = v.left;
    open[size++] = v.right;
  }
  return any;
}

}  // namespace hoodoo::bench
