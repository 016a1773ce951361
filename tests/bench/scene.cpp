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

}  // namespace

float fractal(float x, float y) {
  float sum = 0, amplitude = 1, total = 0;
  x /= 500, y /= 500;
  for (int octave = 11; octave < 18; ++octave) {
    sum += amplitude * (value_noise(x, y, octave) * 2 - 1);
    total += amplitude;
    amplitude /= 2;
    x *= 2.03F, y *= 2.01F;
  }
  return sum / total;
}

namespace {

/// About 100 m, 60 m up and down over 500 m.
float ground(float x, float y) { return 100 + 60 * fractal(x, y); }

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

/// Elevations of the part and `margin` samples around it.
template <class Elevation>
void raise(Scene& scene, int margin, Elevation elevation) {
  const int n = scene.wide + 2 * margin, from = scene.low - margin;
  scene.margin = margin;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      scene.samples.push_back(
          elevation(static_cast<float>(from + i), static_cast<float>(from + j)));
    }
  }
}

/// The window of the samples, and the heights of the part's columns.
void look_up_all(Scene& scene) {
  const int n = scene.wide + 2 * scene.margin;
  // Pixel centres lie on the points of the grid.
  const double corner = scene.low - scene.margin - 0.5;
  scene.window = dem::Window(corner, corner, 1, 1, 0, 0, n, n, scene.samples);
  for (int y = scene.low; y < scene.low + scene.wide; ++y) {
    for (int x = scene.low; x < scene.low + scene.wide; ++x) {
      scene.heights.push_back(static_cast<float>(scene.window.height(x, y)));
    }
  }
}

/// Stretches the elevations to [0, relief].
void stretch(Scene& scene, float relief) {
  const auto [low, high] = std::minmax_element(scene.samples.begin(), scene.samples.end());
  const float from = *low, by = relief / (*high - *low);
  for (float& h : scene.samples) h = (h - from) * by;
}

float sample_at(const Scene& scene, float x, float y) {
  const auto n = static_cast<std::size_t>(scene.wide + 2 * scene.margin);
  const auto index = [&](float v) {
    return static_cast<std::size_t>(static_cast<int>(v) - scene.low + scene.margin);
  };
  return scene.samples[index(y) * n + index(x)];
}

}  // namespace

Scene sea() {
  Scene scene;
  scene.wide = 2000;
  const auto coast = [](float x) { return 1000 + 300 * fractal(x, 100); };
  raise(scene, 24, [&](float x, float y) {
    const float inland = std::clamp((y - coast(x)) / 12, -1.0F, 1.0F);
    return 8 * inland + 8 * fractal(x, y);
  });
  stretch(scene, 33);
  Random random(1);
  for (int i = 0; i < 50'693; ++i) {
    const float x = random.real(0, 1999);
    const float y = std::clamp(coast(x) + random.real(-13, 13), 0.0F, 1999.0F);
    const float reach = random.real(1.5F, 4.5F), z = sample_at(scene, x, y) + random.real(-4, 2);
    scene.balls.push_back({x, y, z, reach, -random.real(5, 15) / 15});
  }
  look_up_all(scene);
  return scene;
}

Scene canyon() {
  Scene scene;
  scene.wide = 1000;
  raise(scene, 24, fractal);
  stretch(scene, 546);
  Random random(1);
  for (int i = 0; i < 137'043; ++i) {
    const float x = random.real(0, 999), y = random.real(300, 700), reach = random.real(2, 6);
    const float z = sample_at(scene, x, y) + random.real(-10, 5);
    scene.balls.push_back({x, y, z, reach, -random.real(5, 15) / 15});
  }
  look_up_all(scene);
  return scene;
}

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
  raise(scene, 8, ground);
  look_up_all(scene);
  find_blocks(scene, band);
  return scene;
}

}  // namespace hoodoo::bench
