// Prints how the engine's speed stands to bare loops and to a hierarchy of volumes asked point by
// point: medians of five runs of processor time, one thread, one build.
#include <fmt/format.h>
#include <hwy/targets.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "engine/tree/evaluate.hpp"
#include "tests/bench/bare.hpp"
#include "tests/bench/engine.hpp"
#include "tests/bench/hierarchy.hpp"
#include "tests/bench/hydrology.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/narrow_band.hpp"
#include "tests/bench/sampling.hpp"
#include "tests/bench/surface.hpp"
#include "tests/bench/whole.hpp"

namespace hoodoo::bench {
namespace {

float step(float u) {
  const float c = std::clamp(u, -1.0F, 1.0F);
  return 0.5F + 0.5F * (c * (1.5F - 0.5F * (c * c)));
}

void hierarchy_values(const Scene& scene, const Hierarchy& hierarchy, const BlockCorner& b,
                      float* out) {
  for (int k = 0; k < side; ++k) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const int x = b[0] + i, y = b[1] + j, z = b[2] + k;
        const float f =
            step((scene.height(x, y) - static_cast<float>(z)) / ground_falloff) +
            hierarchy.sum(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
        out[(k * side + j) * side + i] = std::clamp(f, 0.0F, 1.0F);
      }
    }
  }
}

/// Largest difference between z-fastest and x-fastest values.
float difference(const std::vector<float>& z_fast, const std::vector<float>& x_fast) {
  float most = 0;
  for (int n = 0; n < points_per_block; ++n) {
    const int i = n / (side * side), j = n / side % side, k = n % side;
    most = std::max(most, std::abs(z_fast[static_cast<std::size_t>(n)] -
                                   x_fast[static_cast<std::size_t>((k * side + j) * side + i)]));
  }
  return most;
}

using Buffer = std::vector<float>;

/// Bare splats of all blocks, the elevations of a column of blocks looked up once.
void bare_values(Scene& scene, const Bins& bins, Buffer& out) {
  const BlockCorner* last = nullptr;
  for (const auto& block : scene.blocks) {
    if (last == nullptr || block[0] != (*last)[0] || block[1] != (*last)[1]) look_up(scene, block);
    last = &block;
    bare_splat(scene, bins, block, out.data());
  }
}

void compare_splat(Scene& scene) {
  const Bins bins(scene);
  const Hierarchy hierarchy(scene.balls);
  const Engine engine(scene, list_of(scene.balls, {})), one_by_one(scene, blend_of(scene.balls));
  Buffer a(points_per_block), b(points_per_block);
  const auto whole = [&] {
    Engine part = engine;
    part.prune();
    part.values(scene.blocks, a);
  };
  const auto [engine_seconds, bare_seconds] =
      median_seconds(whole, [&] { bare_values(scene, bins, b); });
  float worst = 0;
  for (std::size_t i = 0; i < scene.blocks.size(); i += 7) {
    engine.values({&scene.blocks[i], 1}, a);
    bare_splat(scene, bins, scene.blocks[i], b.data());
    worst = std::max(worst, difference(a, b));
  }
  const auto [slow_seconds, table_seconds] = median_seconds(
      [&] {
        for (const auto& block : scene.blocks) hierarchy_values(scene, hierarchy, block, b.data());
      },
      [&] {
        for (const auto& block : scene.blocks) bare_splat(scene, bins, block, b.data());
      });
  fmt::print("50,000 smooth balls, {} blocks, results differ by {:.1e}\n", scene.blocks.size(),
             worst);
  rate("engine: pruned, compiled, sampled on grids", scene.points(), engine_seconds);
  rate("bare splat, elevations looked up", scene.points(), bare_seconds);
  rate("bare splat, elevations known", scene.points(), table_seconds);
  rate("hierarchy, point by point, elevations known", scene.points(), slow_seconds);
  std::vector<BlockCorner> few;
  for (std::size_t i = 0; i < scene.blocks.size(); i += 101) few.push_back(scene.blocks[i]);
  const auto [blend_seconds, unused] = median_seconds([&] { one_by_one.values(few, a); }, [] {});
  rate("engine, a blend of 50,000 nodes, not pruned",
       static_cast<double>(few.size()) * points_per_block, blend_seconds);
  ratio("engine / hierarchy", slow_seconds / engine_seconds, ">= 60");
  ratio("engine / bare splat, elevations looked up", bare_seconds / engine_seconds, ">= 0.5");
  ratio("engine / bare splat, elevations known", table_seconds / engine_seconds, ">= 0.5");
}

void compare_rough(const Scene& scene) {
  const Rough rough{1, {6.7, 3, 5}, static_cast<float>(tree::half_falloff)};
  const Bins bins(scene, rough.amplitude);
  const Engine engine(scene, list_of(scene.balls, rough));
  Buffer a(points_per_block), b(points_per_block);
  const auto [engine_seconds, bare_seconds] =
      median_seconds([&] { engine.values(scene.blocks, a); },
                     [&] {
                       for (const auto& block : scene.blocks) {
                         bare_rough_splat(scene, bins, rough, block, b.data());
                       }
                     });
  float worst = 0;
  for (std::size_t i = 0; i < scene.blocks.size(); i += 7) {
    engine.values({&scene.blocks[i], 1}, a);
    bare_rough_splat(scene, bins, rough, scene.blocks[i], b.data());
    worst = std::max(worst, difference(a, b));
  }
  fmt::print("the same, each ball roughened by 3 octaves, results differ by {:.1e}\n", worst);
  rate("engine", scene.points(), engine_seconds);
  rate("bare splat", scene.points(), bare_seconds);
  ratio("engine / bare splat, rough", bare_seconds / engine_seconds, ">= 0.6");
}

void compare_turbulence(const Scene& scene) {
  tree::Strata strata;
  strata.wavelength = 33;
  strata.octaves = 5;
  const tree::Node tree{strata, {}};
  const Engine engine(scene, list_of(scene.balls, {}));
  const auto at = engine.points();
  Buffer a(points_per_block), b(points_per_block);
  const auto [engine_seconds, bare_seconds] = median_seconds(
      [&] {
        for (const auto& block : scene.blocks) {
          const Vec3 origin{static_cast<double>(block[0]), static_cast<double>(block[1]),
                            static_cast<double>(block[2])};
          const auto compiled =
              tree::compile(tree, {origin, {origin, origin + Vec3{side, side, side}}});
          for (std::size_t i = 0; i < points_per_block; i += tree::batch_size) {
            compiled.kernel->values(
                {at.x.subspan(i, tree::batch_size), at.y.subspan(i, tree::batch_size),
                 at.z.subspan(i, tree::batch_size)},
                std::span(a).subspan(i, tree::batch_size));
          }
        }
      },
      [&] {
        for (const auto& block : scene.blocks) bare_turbulence(strata.noise(), block, b.data());
      });
  fmt::print("5 octaves of turbulence at every point\n");
  rate("engine (strata)", scene.points(), engine_seconds);
  rate("bare loop", scene.points(), bare_seconds);
  ratio("engine / bare loop, turbulence", bare_seconds / engine_seconds, ">= 0.8");
}

void compare_gradients(const Scene& scene, const Rough& rough, const char* what) {
  const Engine engine(scene, list_of(scene.balls, rough));
  std::vector<std::unique_ptr<const tree::Field>> fields;
  for (const auto& block : scene.blocks) fields.push_back(engine.field(block));
  Buffer v(points_per_block), x(v), y(v), z(v);
  const auto [gradient_seconds, value_seconds] = median_seconds(
      [&] {
        for (const auto& field : fields) field->gradients(engine.points(), v, {x, y, z});
      },
      [&] {
        for (const auto& field : fields) field->values(engine.points(), v);
      });
  rate("values in batches", scene.points(), value_seconds);
  rate("gradients in batches", scene.points(), gradient_seconds);
  ratio(what, gradient_seconds / value_seconds, "<= 3");
}

/// As tiling/volume finds it: uniform blocks are not sampled, crossings and normals included.
void compare_narrow_band(const Scene& scene, int count, double& least) {
  const NarrowBand band(scene);
  std::size_t crossings = 0;
  const auto seconds = median_seconds([&] { crossings = band.crossings(); }, [] {})[0];
  fmt::print("  {:7} balls: narrow band with {} crossings {:7.1f} ms\n", count, crossings,
             1e3 * seconds);
  if (count == 100) least = seconds;
  if (count == 10'000) ratio("narrow band of 10,000 / of 100", seconds / least, "<= 3");
}

void compare_growth() {
  double least = 0, least_dense = 0, least_bare = 0;
  fmt::print("256 x 256 m, elevations looked up\n");
  for (const int count : {100, 1'000, 10'000, 100'000}) {
    Scene scene = strew(count, 768, 768 + 256, 768, 256, 16);
    compare_narrow_band(scene, count, least);
    const Bins bins(scene);
    const Engine engine(scene, list_of(scene.balls, {}));
    Buffer a(points_per_block), b(points_per_block);
    const auto seconds = median_seconds([&] { engine.values(scene.blocks, a); },
                                        [&] { bare_values(scene, bins, b); });
    fmt::print("  {:7} balls: all points of {} blocks {:7.2f} ms, bare splat {:7.2f} ms\n", count,
               scene.blocks.size(), 1e3 * seconds[0], 1e3 * seconds[1]);
    if (count == 100) least_dense = seconds[0], least_bare = seconds[1];
    if (count != 10'000) continue;
    ratio("all points with 10,000 / with 100", seconds[0] / least_dense, "<= 3");
    ratio("the same of the bare splat", seconds[1] / least_bare, "to compare");
  }
}

double heap_bytes() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

/// What a tree of so many balls holds on the heap, index included.
double tree_bytes(int count) {
  const Scene scene = strew(count, 0, 2000, 704, 16, 16);
  const double before = heap_bytes();
  const tree::Node node = list_of(scene.balls, {});
  const double bytes = heap_bytes() - before;
  return bytes + static_cast<double>(sizeof(tree::Node));
}

void compare_memory() {
  const double small = tree_bytes(10'000), large = tree_bytes(165'773);
  fmt::print("memory of a tree\n  165,773 balls: {:.2f} MB (goal: <= 7.8)\n", large / 1e6);
  ratio("bytes per ball beyond 10,000", (large - small) / (165'773 - 10'000), "<= 47");
}

}  // namespace
}  // namespace hoodoo::bench

/// Arguments name what to run; without any, all.
int main(int count, char** arguments) {
  using namespace hoodoo::bench;
  const std::vector<std::string_view> chosen(arguments + 1, arguments + count);
  const auto wanted = [&](std::string_view name) {
    return chosen.empty() || std::find(chosen.begin(), chosen.end(), name) != chosen.end();
  };
  fmt::print("instruction set: {}\n",
             hwy::TargetName(hwy::SupportedTargets() & -hwy::SupportedTargets()));
  if (wanted("grid")) compare_ready_grid();
  if (wanted("surface")) compare_surface();
  if (wanted("whole")) compare_whole();
  if (wanted("hydrology")) compare_hydrology();
  if (wanted("sampling")) compare_sampling();
  Scene scene = strew(50'000, 0, 2000, 704, 256, 16);
  if (wanted("splat")) compare_splat(scene);
  if (wanted("rough")) compare_rough(scene);
  if (wanted("turbulence")) compare_turbulence(scene);
  if (wanted("gradient")) {
    fmt::print("gradients, smooth balls\n");
    compare_gradients(scene, {}, "gradient / value");
    fmt::print("gradients, rough balls\n");
    compare_gradients(scene, {1, {6.7, 3, 5}, 1}, "gradient / value, rough");
  }
  if (wanted("growth")) compare_growth();
  if (wanted("memory")) compare_memory();
  return 0;
}
