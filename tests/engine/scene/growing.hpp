#pragma once
#include <string_view>
#include <variant>
#include <vector>

#include "engine/tree/balls.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {

/// A scene with one generator over the sample DEM, and what it makes.
class GrowingTest : public SceneTest {
 protected:
  static nlohmann::json with(nlohmann::json operation) {
    auto scene = minimal();
    scene["operations"].push_back(std::move(operation));
    return scene;
  }
  static Scene grown(const nlohmann::json& scene, int threads = 1) {
    OpenSettings settings{.cache = folder() / "cache", .ingest = {}, .keep_marks = true};
    settings.ingest.threads = threads;
    return open(scene, sources(), settings);
  }
  /// Every ball of every step, in their order.
  static std::vector<tree::Ball> balls(const Scene& scene) {
    std::vector<tree::Ball> all;
    for (const auto& step : scene.ground.steps) {
      std::visit(
          [&](const auto& node) {
            if constexpr (requires { node.balls.list(); }) {
              const auto list = node.balls.list();
              all.insert(all.end(), list.begin(), list.end());
            }
          },
          step.tree.value);
    }
    return all;
  }
  /// Whether the points of a lattice in a box are solid, x fastest, from its least corner.
  static std::vector<bool> solid(const Scene& scene, const Box& box, double step) {
    std::vector<float> x, y, z;
    for (double c = 0; c <= box.max.z - box.min.z; c += step) {
      for (double b = 0; b <= box.max.y - box.min.y; b += step) {
        for (double a = 0; a <= box.max.x - box.min.x; a += step) {
          x.push_back(static_cast<float>(a));
          y.push_back(static_cast<float>(b));
          z.push_back(static_cast<float>(c));
        }
      }
    }
    std::vector<dem::Window> windows;
    for (const auto& pyramid : scene.pyramids) windows.push_back(pyramid->window(0, box));
    std::vector<float> f(x.size());
    tree::compile(scene.ground, windows, box.min, box)->values({x, y, z}, f);
    std::vector<bool> inside;
    for (const float v : f) inside.push_back(v > 0.5F);
    return inside;
  }
  /// How many points of the lattice are solid in the first alone.
  static std::size_t lost(const Scene& before, const Scene& after, const Box& box, double step) {
    const auto a = solid(before, box, step), b = solid(after, box, step);
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += a[i] && !b[i] ? 1 : 0;
    return count;
  }
  /// The steps that generators made.
  static std::vector<tree::Node> trees(const Scene& scene) {
    std::vector<tree::Node> all;
    for (const auto& step : scene.ground.steps) all.push_back(step.tree);
    return all;
  }
  static std::uint64_t counted(const Scene& scene, std::string_view what) {
    for (const auto& [name, count] : scene.grown.front().counts) {
      if (name == what) return count;
    }
    return 0;
  }
};

}  // namespace hoodoo::scene
