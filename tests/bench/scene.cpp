#include "tests/bench/scene.hpp"

#include <algorithm>
#include <cmath>

namespace hoodoo::bench {
namespace {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  float real(float low, float high) {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return low + (high - low) * static_cast<float>((z ^ (z >> 31)) >> 40) * 0x1p-24F;
  }

 private:
  std::uint64_t state_;
};

float lattice(int x, int y, int octave) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343U ^
                    static_cast<std::uint32_t>(y) * 0xd8163841U ^
                    static_cast<std::uint32_t>(octave) * 0xcb1ab31fU;
  h = (h ^ (h >> 15)) * 0x2c1b3c6dU;
  h = (h ^ (h >> 12)) * 0x297a2d39U;
  return static_cast<float>(h ^ (h >> 15)) * 0x1p-32F;
}

float value_noise(float x, float y, int octave) {
  const float ix = std::floor(x), iy = std::floor(y), fx = x - ix, fy = y - iy;
  const auto at = [&](int i, int j) {
    return lattice(static_cast<int>(ix) + i, static_cast<int>(iy) + j, octave);
  };
  const auto smooth = [](float t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const float u = smooth(fx), v = smooth(fy);
  const float a = at(0, 0), b = at(1, 0), c = at(0, 1), d = at(1, 1);
  return a + (b - a) * u + (c - a) * v + (a - b - c + d) * u * v;
}

/// About 100 m, 60 m up and down over 500 m.
float ground(float x, float y) {
  float sum = 0, amplitude = 1, total = 0;
  x /= 500, y /= 500;
  for (int octave = 11; octave < 18; ++octave) {
    sum += amplitude * (value_noise(x, y, octave) * 2 - 1);
    total += amplitude;
    amplitude /= 2;
    x *= 2.03F, y *= 2.01F;
  }
  return 100 + 60 * sum / total;
}

void find_blocks(Scene& scene, float band) {
  for (int y = scene.low; y < scene.low + scene.wide; y += side) {
    for (int x = scene.low; x < scene.low + scene.wide; x += side) {
      float low = 1e9F, high = -1e9F;
      for (int j = y; j < y + side; ++j) {
        for (int i = x; i < x + side; ++i) {
          low = std::min(low, scene.height(i, j));
          high = std::max(high, scene.height(i, j));
        }
      }
      const int bottom = static_cast<int>(std::floor((low - band) / side)) * side;
      for (int z = bottom; static_cast<float>(z) < high + band; z += side) {
        scene.blocks.push_back({x, y, z});
      }
    }
  }
}

}  // namespace

Scene strew(int count, float from, float to, int low, int wide, float band) {
  Scene scene;
  scene.low = low;
  scene.wide = wide;
  Random random(1);
  for (int i = 0; i < count; ++i) {
    const float x = random.real(from, to), y = random.real(from, to), reach = random.real(4, 12);
    const float z = ground(x, y) + random.real(-10, 5);
    scene.balls.push_back({x, y, z, reach, -random.real(5, 15) / 15});
  }
  constexpr int margin = 8;
  const int n = wide + 2 * margin;
  std::vector<float> samples;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      samples.push_back(
          ground(static_cast<float>(low - margin + i), static_cast<float>(low - margin + j)));
    }
  }
  // Pixel centres lie on the points of the grid.
  scene.window = dem::Window(low - margin - 0.5, low - margin - 0.5, 1, 1, 0, 0, n, n, samples);
  for (int y = low; y < low + wide; ++y) {
    for (int x = low; x < low + wide; ++x) {
      scene.heights.push_back(static_cast<float>(scene.window.height(x, y)));
    }
  }
  find_blocks(scene, band);
  return scene;
}

}  // namespace hoodoo::bench
