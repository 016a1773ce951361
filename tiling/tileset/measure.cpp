#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "tiling/glb/earth.hpp"
#include "tiling/tileset/content.hpp"
#include "tiling/tileset/farthest.hpp"
#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/patch.hpp"
#include "tiling/tileset/tree.hpp"

namespace hoodoo::tileset {
namespace {

/// Measured distances may be so many spacings of the level below too large: with more, the errors
/// stated would be three times the true ones; with less, finding them takes longer.
constexpr double slack = 1.8;

/// Two-sided distance between a tile and its children, or up to `more` above it; what one side
/// lacks altogether is off by the size of the other.
double distance(const Patch& tile, const Patch& children, const Box& box, double side,
                double more) {
  if (tile.triangles.empty() || children.triangles.empty()) return length(box.max - box.min);
  // The children's triangles are small, and soon answered for by one of the tile's.
  const double from_children = farthest(children, tile, side, more);
  return farthest(tile, children, side, more, from_children);
}

/// Notes in the tiles what an earlier, complete index in `folder` says of the same contents.
void take_over(Index& index, const std::filesystem::path& folder) {
  for (auto& tile : index.tiles) tile.same = false;
  if (!std::filesystem::exists(folder / "bake.json")) return;
  try {
    ManifestReader before(folder);
    if (!before.header().complete) return;
    while (const auto entry = before.next()) {
      auto* tile = plan::find(std::span<plan::Tile>(index.tiles), entry->key);
      if (tile == nullptr || !tile->has_content() || entry->record.empty) continue;
      if (tile->slice != entry->record.slice &&
          index.read(*tile).content != entry->record.content) {
        continue;
      }
      tile->same = true;
      tile->error = entry->error;
    }
  } catch (const Error&) {
    for (auto& tile : index.tiles) tile.same = false;  // of another release, or damaged
  }
}

class Measurement {
 public:
  Measurement(Index& index, const std::filesystem::path& folder)
      : index_(index), folder_(folder), tree_(index, folder) {}

  void run(int threads, const std::stop_token& stop) {
    tbb::task_arena arena(threads);
    auto from = index_.tiles.begin();
    for (int level = 0; level < index_.levels; ++level) {
      const auto to = std::find_if(from, index_.tiles.end(),
                                   [level](const auto& tile) { return tile.level > level; });
      arena.execute([&] {
        tbb::parallel_for_each(from, to, [&](plan::Tile& tile) {
          if (stop.stop_requested()) throw Error(Fault::cancelled, "", "stopped");
          const double error = tile.shown ? error_of(tile) : 0;
          tile.same = tile.same && tile.error == error;
          tile.error = error;
        });
      });
      from = to;
    }
  }

 private:
  double error_of(const plan::Tile& tile) const {
    const auto children = tree_.children(tile);
    if (children.empty()) return 0;
    const bool known =
        tile.same && std::ranges::all_of(children, [](const auto* child) { return child->same; });
    if (known) return tile.error;
    double below = 0;
    for (const auto* child : children) below = std::max(below, child->error);
    const double spacing = index_.lattice.spacing(tile.level - 1);
    double measured = index_.lattice.spacing(tile.level);  // where the tile itself is missing
    if (tile.finished) {
      const Box box = tree_.box(tile);
      Patch own, finer;
      add_content(own, tile, box.min);
      for (const auto* child : children) add_surfaces(finer, *child, box.min);
      measured = distance(own, finer, box, 2 * spacing, slack * spacing);
    }
    return measured + below + index_.lattice.step(tile.level);
  }

  void add_content(Patch& patch, const plan::Tile& tile, const Vec3& corner) const {
    if (!tile.has_content()) return;
    // On the Earth, too, points are metres: distances need no map.
    const double step = index_.lattice.step(tile.level);
    const double fine = index_.frame.vertical.empty() ? step : step / glb::finer;
    add(patch, read_tile(folder_, index_.read(tile), fine, glb::Wanted::surface), corner);
  }
  /// What is shown in place of `tile`: its content, or what is below it where it has none.
  void add_surfaces(Patch& patch, const plan::Tile& tile, const Vec3& corner) const {
    if (tile.has_content()) return add_content(patch, tile, corner);
    for (const auto* child : tree_.children(tile)) add_surfaces(patch, *child, corner);
  }

  Index& index_;
  const std::filesystem::path& folder_;
  const Tree tree_;
};

}  // namespace

void measure_errors(Index& index, const std::filesystem::path& folder, int threads,
                    std::stop_token stop) {
  take_over(index, folder);
  Measurement(index, folder).run(threads, stop);
}

void estimate_errors(Index& index) {
  for (auto& tile : index.tiles) {
    tile.error = tile.level == 0 ? 0 : index.lattice.spacing(tile.level);
  }
}

}  // namespace hoodoo::tileset
