// How far the surface is from the elevations it stands for.
//
//   accuracy SCENE.json CACHE [--tiles N]
//
// Prints one line of JSON: for leaf vertices outside every primitive's support and before
// simplification, the distance to the interpolated elevations (mean, 99.9th percentile, largest) in
// spacings; and for 10,000 random points of the elevations, by how much the simplified leaf is
// farther from them than the unsimplified one, against the stated error of simplification. Ends
// with 1 when one of the bounds (0.03, 0.2, the stated error) is broken.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/base/random.hpp"
#include "engine/scene/scene.hpp"
#include "tiling/lod/buckets.hpp"
#include "tiling/lod/lod.hpp"
#include "tiling/plan/plan.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/surface/mesh.hpp"
#include "tiling/volume/volume.hpp"

using namespace hoodoo;

namespace {

constexpr std::size_t wanted_points = 10000;

struct Statistics {
  std::vector<float> offsets;  // of vertices, in spacings
  std::size_t random_points = 0, broken = 0;
  double worst_excess = -1e30;  // [spacings], shipped less unsimplified less stated
  double stated = 0;            // largest stated error [spacings]
};

/// Upper bound on the distance from `p` to z = h(x, y): to the nearest of samples of the elevations
/// around it, on a lattice that closes in on the best so far until it is fine to a 500th of the
/// first reach, itself no longer than the vertical distance.
double distance_to(const dem::Window& window, const Vec3& p, double spacing) {
  double best = std::abs(window.height(p.x, p.y) - p.z);
  if (best < 0.02 * spacing) return best;
  constexpr int half = 6;
  double x = p.x, y = p.y, reach = best;
  for (int round = 0; round < 4; ++round, reach /= half - 1) {
    const double cx = x, cy = y;
    for (int j = -half; j <= half; ++j) {
      for (int i = -half; i <= half; ++i) {
        const double u = cx + i * reach / half, v = cy + j * reach / half;
        const double d = length(Vec3{u, v, window.height(u, v)} - p);
        if (d < best) best = d, x = u, y = v;
      }
    }
  }
  return best;
}

std::vector<Vec3> in_metres(const surface::Surface& s, const Vec3& origin, double step) {
  std::vector<Vec3> points;
  points.reserve(s.points.size());
  for (const auto& p : s.points) {
    points.push_back(origin + Vec3{static_cast<double>(p[0]), static_cast<double>(p[1]),
                                   static_cast<double>(p[2])} *
                                  step);
  }
  return points;
}

bool touched(const std::vector<Box>& supports, const Vec3& p, double margin) {
  return std::any_of(supports.begin(), supports.end(),
                     [&](const Box& b) { return b.grown(margin).contains(p); });
}

class Tile {
 public:
  Tile(const scene::Scene& scene, const plan::Lattice& lattice, const plan::Key& key,
       const std::vector<Box>& supports)
      : slice_(slice::cut(scene, lattice, key)), supports_(supports) {
    slice::Land land(slice_, scene.pyramids);
    const auto volume = volume::sample(land);
    const double step = slice_.step();
    for (int a = 0; a < 3; ++a) {
      origin_[a] =
          static_cast<double>(volume.low()[static_cast<std::size_t>(a)]) * slice_.spacing();
    }
    const auto whole = surface::extract(volume, land);
    const auto simple = lod::simplify(whole, slice_.simplify / step, slice_.lattice.units());
    whole_points_ = in_metres(whole, origin_, step);
    whole_ = whole.triangles;
    simple_points_ = in_metres(simple.surface, origin_, step);
    simple_ = simple.surface.triangles;
    stated_ = simple.error * step;
    window_ = scene.pyramids[0]->window(0, slice::reach(lattice, key));
  }

  void measure_vertices(Statistics& all) const {
    for (const auto& p : whole_points_) {
      if (touched(supports_, p, slice_.spacing())) continue;
      all.offsets.push_back(
          static_cast<float>(distance_to(window_, p, slice_.spacing()) / slice_.spacing()));
    }
  }

  void measure_points(Statistics& all, std::size_t count, std::uint64_t seed) const {
    all.stated = std::max(all.stated, stated_ / slice_.spacing());
    if (whole_.empty()) return;
    const lod::Buckets whole(whole_points_, whole_, slice_.spacing());
    const lod::Buckets simple(simple_points_, simple_, slice_.spacing());
    const Box area = slice_.lattice.area(slice_.key).grown(-2 * slice_.spacing());
    for (std::size_t i = 0; i < count; ++i) {
      const double x = area.min.x + unit_real(random_bits(seed, i, 0)) * (area.max.x - area.min.x);
      const double y = area.min.y + unit_real(random_bits(seed, i, 1)) * (area.max.y - area.min.y);
      const Vec3 p{x, y, window_.height(x, y)};
      if (!inside(x, y) || touched(supports_, p, 2 * slice_.spacing())) continue;
      ++all.random_points;
      std::uint32_t hint = 0, other = 0;
      const double excess =
          std::sqrt(simple.beyond(p, 0, hint)) - std::sqrt(whole.beyond(p, 0, other)) - stated_;
      all.worst_excess = std::max(all.worst_excess, excess / slice_.spacing());
      if (excess > 1e-9) ++all.broken;
    }
  }

 private:
  bool inside(double x, double y) const {
    for (int j = -2; j <= 2; ++j) {
      for (int i = -2; i <= 2; ++i) {
        if (!window_.valid(x + i * slice_.spacing(), y + j * slice_.spacing())) return false;
      }
    }
    return true;
  }

  slice::Slice slice_;
  const std::vector<Box>& supports_;
  Vec3 origin_;
  dem::Window window_;
  std::vector<Vec3> whole_points_, simple_points_;
  std::vector<std::array<std::uint32_t, 3>> whole_, simple_;
  double stated_ = 0;
};

std::vector<Box> supports_of(const tree::Ground& ground) {
  std::vector<Box> boxes;
  for (const auto& step : ground.steps) {
    tree::Ground alone = ground;
    alone.steps = {step};
    boxes.push_back(tree::influence(alone));
  }
  return boxes;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::cerr << "accuracy SCENE.json CACHE [--tiles N]\n";
    return 2;
  }
  const std::filesystem::path file = argv[1];
  scene::OpenSettings settings;
  settings.cache = argv[2];
  settings.ingest.threads = 2;
  const auto scene = scene::open(scene::read(file), {file.parent_path(), {}}, settings);
  const auto plan = plan::make(scene);
  std::vector<plan::Key> leaves;
  for (const auto& tile : plan.tiles) {
    const auto key = tile.key();
    if (key.level == 0) leaves.push_back(key);
  }
  std::size_t most = leaves.size();
  if (argc > 4 && std::string(argv[3]) == "--tiles") most = std::stoul(argv[4]);
  const std::size_t stride = std::max<std::size_t>(1, (leaves.size() + most - 1) / most);
  const std::size_t used = (leaves.size() + stride - 1) / stride;
  const auto supports = supports_of(scene.ground);
  Statistics all;
  // A small or ragged world fills a part of its tiles only: more rounds then.
  for (std::size_t round = 0; round < 50 && all.random_points < wanted_points; ++round) {
    for (std::size_t i = 0; i < leaves.size(); i += stride) {
      const Tile tile(scene, plan.lattice, leaves[i], supports);
      if (round == 0) tile.measure_vertices(all);
      tile.measure_points(all, 4 * wanted_points / used + 1, round * leaves.size() + i);
    }
  }
  std::sort(all.offsets.begin(), all.offsets.end());
  double mean = 0;
  for (const float v : all.offsets) mean += v;
  const auto n = all.offsets.size();
  mean /= static_cast<double>(std::max<std::size_t>(n, 1));
  const double p999 = n == 0 ? 0 : all.offsets[(n - 1) * 999 / 1000];
  const double largest = n == 0 ? 0 : all.offsets.back();
  const bool good =
      n > 0 && all.random_points >= wanted_points && mean <= 0.03 && p999 <= 0.2 && all.broken == 0;
  fmt::print(
      "{{\"scene\": \"{}\", \"tiles\": {}, \"of\": {}, \"vertices\": {}, \"mean\": {:.5f}, "
      "\"p999\": {:.5f}, \"largest\": {:.4f}, \"points\": {}, \"broken\": {}, "
      "\"worstExcess\": {:.5f}, \"stated\": {:.4f}, \"good\": {}}}\n",
      scene.name, used, leaves.size(), n, mean, p999, largest, all.random_points, all.broken,
      all.worst_excess, all.stated, good);
  return good ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << "accuracy: " << error.what() << "\n";
  return 2;
}
