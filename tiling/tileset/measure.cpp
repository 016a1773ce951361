#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <mutex>
#include <optional>

#include "tiling/glb/earth.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/lod/deviation.hpp"
#include "tiling/store/store.hpp"
#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/patch.hpp"
#include "tiling/tileset/tree.hpp"

namespace hoodoo::tileset {
namespace {

/// Largest distance of samples of `from`, at most `spacing` apart, from `to`.
double farthest(const Patch& from, const Patch& to, double spacing) {
  const lod::Buckets buckets(to.points, to.triangles, 3 * spacing);
  lod::Farthest farthest(Box::infinity, spacing / 64);
  for (const auto& [ia, ib, ic] : from.triangles) {
    const Vec3 &a = from.points[ia], &b = from.points[ib], &c = from.points[ic];
    // Corners as triangles come, for the sake of the nearest found last; most are met again and
    // answered at once.
    farthest.look(a, buckets);
    farthest.look(b, buckets);
    farthest.look(c, buckets);
    lod::for_each_sample(a, b, c, spacing, [&](const Vec3& p) { farthest.look(p, buckets); });
  }
  return farthest.distance();
}

/// Two-sided distance between a tile and its children; what one side lacks altogether is off by
/// the size of the other.
double distance(const Patch& tile, const Patch& children, const Box& box, double spacing) {
  if (tile.triangles.empty() || children.triangles.empty()) return length(box.max - box.min);
  return std::max(farthest(tile, children, spacing), farthest(children, tile, spacing));
}

class Measurement {
 public:
  Measurement(const Bake& bake, const std::filesystem::path& folder)
      : bake_(bake), folder_(folder), tree_(make_tree(bake)) {
    try {
      if (std::filesystem::exists(folder / "bake.json")) before_ = read_manifest(folder);
    } catch (const Error&) {
      before_.reset();  // of another release, or damaged
    }
  }

  std::map<plan::Key, double> run(int threads, const std::stop_token& stop) {
    tbb::task_arena arena(threads);
    for (int level = 0; level < bake_.levels; ++level) {
      std::vector<plan::Key> keys;
      for (const auto& [key, node] : tree_.nodes) {
        if (key.level == level) keys.push_back(key);
      }
      std::mutex mutex;
      std::map<plan::Key, double> measured;
      arena.execute([&] {
        tbb::parallel_for_each(keys.begin(), keys.end(), [&](const plan::Key& key) {
          if (stop.stop_requested()) throw Error(Fault::cancelled, "", "stopped");
          const double error = error_of(key);
          const std::lock_guard lock(mutex);
          measured[key] = error;
        });
      });
      errors_.merge(measured);
    }
    return std::move(errors_);
  }

 private:
  double error_of(const plan::Key& key) const {
    const auto& node = tree_.nodes.at(key);
    if (node.children.empty()) return 0;
    if (const auto known = known_error(key, node)) return *known;
    double below = 0;
    for (const auto& child : node.children) below = std::max(below, errors_.at(child));
    const double spacing = bake_.lattice.spacing(key.level - 1);
    double measured = bake_.lattice.spacing(key.level);  // where the tile itself is missing
    if (node.record != nullptr) {
      Patch tile, children;
      add_content(tile, key, node.box.min);
      for (const auto& child : node.children) add_surfaces(children, child, node.box.min);
      measured = distance(tile, children, node.box, spacing);
    }
    return measured + spacing + below + bake_.lattice.step(key.level);
  }

  void add_content(Patch& patch, const plan::Key& key, const Vec3& corner) const {
    const auto& node = tree_.nodes.at(key);
    if (!node.has_content()) return;
    const auto bytes = store::get_tile(folder_, node.record->content);
    const auto where = store::tile_path(node.record->content).string();
    // On the Earth, too, points are metres: distances need no map.
    const double step = bake_.lattice.step(key.level);
    add(patch, glb::read(bytes, bake_.frame.vertical.empty() ? step : step / glb::finer, where),
        corner);
  }
  /// What is shown in place of `key`: its content, or what is below it where it has none.
  void add_surfaces(Patch& patch, const plan::Key& key, const Vec3& corner) const {
    const auto& node = tree_.nodes.at(key);
    if (node.has_content()) return add_content(patch, key, corner);
    for (const auto& child : node.children) add_surfaces(patch, child, corner);
  }

  /// The error an earlier index gives, where it was measured on the same files.
  std::optional<double> known_error(const plan::Key& key, const Tree::Node& node) const {
    if (!before_ || !before_->complete || node.record == nullptr) return std::nullopt;
    if (!same_file(*node.record)) return std::nullopt;
    for (const auto& child : node.children) {
      const auto& below = tree_.nodes.at(child);
      const auto error = before_->errors.find(child);
      if (below.record == nullptr || !same_file(*below.record)) return std::nullopt;
      if (error == before_->errors.end() || error->second != errors_.at(child)) return std::nullopt;
    }
    const auto known = before_->errors.find(key);
    return known == before_->errors.end() ? std::nullopt : std::optional(known->second);
  }
  bool same_file(const Record& record) const {
    const auto at = std::ranges::lower_bound(before_->records, record.key, {}, &Record::key);
    return at != before_->records.end() && at->key == record.key && at->empty == record.empty &&
           at->content == record.content;
  }

  const Bake& bake_;
  const std::filesystem::path& folder_;
  Tree tree_;
  std::optional<Manifest> before_;
  std::map<plan::Key, double> errors_;  // of the levels done
};

}  // namespace

std::map<plan::Key, double> measure_errors(const Bake& bake, const std::filesystem::path& folder,
                                           int threads, std::stop_token stop) {
  return Measurement(bake, folder).run(threads, stop);
}

std::map<plan::Key, double> estimate_errors(const Bake& bake) {
  std::map<plan::Key, double> errors;
  for (const auto& key : bake.planned) {
    errors[key] = key.level == 0 ? 0 : bake.lattice.spacing(key.level);
  }
  return errors;
}

}  // namespace hoodoo::tileset
