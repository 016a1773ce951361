#include "tests/bench/narrow_band.hpp"

#include <memory>
#include <optional>
#include <string>

#include "tests/bench/engine.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/slice/slice.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::bench {
namespace {

/// Elevations that are in memory as one window.
class Table final : public dem::Pyramid {
 public:
  Table(const dem::Window& window, const Box& extent) : window_(window), extent_(extent) {
    const double wide = extent.max.x - extent.min.x;
    const auto pixels = static_cast<std::int64_t>(wide);
    levels_.push_back({extent.min.x, extent.min.y, 1, 1, pixels, pixels});
  }
  const std::vector<Level>& levels() const override { return levels_; }
  const std::string& name() const override { return name_; }
  const Digest& digest() const override { return digest_; }
  Box extent() const override { return extent_; }
  std::vector<Digest> chunks(int, const Box&) const override { return {digest_}; }
  dem::Window window(int, const Box&) const override { return window_; }
  std::optional<Interval> bounds(int, const Box& area) const override {
    return window_.bounds(area);
  }

 private:
  dem::Window window_;
  Box extent_;
  std::vector<Level> levels_;
  std::string name_ = "table";
  Digest digest_ = sha256("table");
};

}  // namespace

NarrowBand::NarrowBand(const Scene& scene) {
  const double low = scene.low, high = scene.low + scene.wide;
  const Box extent{{low, low, -1000}, {high, high, 1000}};
  scene_.bake.tile_cells = tile_cells;
  scene_.ground = ground_of(list_of(scene.balls, {}));
  scene_.pyramids.push_back(std::make_shared<Table>(scene.window, extent));
  scene_.extent = extent;
  for (int y = scene.low; y < scene.low + scene.wide; y += tile_cells) {
    for (int x = scene.low; x < scene.low + scene.wide; x += tile_cells) {
      tiles_.push_back({0, x / tile_cells, y / tile_cells});
    }
  }
}

std::size_t NarrowBand::crossings() const {
  const plan::Lattice lattice{1, dem::step_of(1), tile_cells};
  std::size_t n = 0;
  for (const auto& tile : tiles_) {
    const auto slice = slice::cut(scene_, lattice, tile);
    slice::Land land(slice, scene_.pyramids);
    volume::sample(land).for_each_crossing([&](int, const volume::Index&) { ++n; });
  }
  return n;
}

}  // namespace hoodoo::bench
