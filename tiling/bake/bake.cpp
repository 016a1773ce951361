#include "tiling/bake/bake.hpp"

#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/base/error.hpp"
#include "tiling/bake/folder.hpp"
#include "tiling/bake/tile.hpp"
#include "tiling/slice/slice.hpp"
#include "tiling/store/cache.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::bake {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Progress shared by the workers.
class Watch {
 public:
  explicit Watch(const Settings& settings) : settings_(settings) {}

  template <class Change>
  void change(Change change) {
    const std::lock_guard lock(mutex_);
    change(progress_);
    if (settings_.progress) settings_.progress(progress_);
  }
  Progress progress() const {
    const std::lock_guard lock(mutex_);
    return progress_;
  }

 private:
  const Settings& settings_;
  mutable std::mutex mutex_;
  Progress progress_;
};

[[noreturn]] void throw_cancelled() {
  throw Error(Fault::cancelled, "", "stopped; the same command continues");
}

/// A digest of all that the tiles of a scene depend on.
Digest digest_of(const scene::Scene& scene) {
  json all = {
      {"engine", slice::engine_version()},
      {"frame", {scene.frame.crs, scene.frame.origin_x, scene.frame.origin_y}},
      {"spacing", scene.spacing},
      {"profile", scene.bake.profile},
      {"simplify", {scene.bake.simplify, scene.bake.simplify_coarse}},
      {"tile_cells", scene.bake.tile_cells},
      {"world", {scene.extent.min.x, scene.extent.min.y, scene.extent.max.x, scene.extent.max.y}},
      {"ground", tree::to_json(scene.ground)},
      {"pyramids", json::array()}};
  for (const auto& pyramid : scene.pyramids) all["pyramids"].push_back(pyramid->digest().hex());
  if (scene.bake.draco_speed != 5) all["draco_speed"] = scene.bake.draco_speed;
  if (!scene.frame.vertical.empty()) all["vertical"] = scene.frame.vertical;
  return sha256(all.dump());
}

/// One run: the state its steps share.
class Run {
 public:
  Run(const fs::path& folder, const Settings& settings)
      : folder_(folder), settings_(settings), watch_(settings) {
    if (!settings.cache.empty()) cache_ = std::make_unique<store::Cache>(settings.cache);
  }

  void open(const json& scene, const scene::Sources& sources) {
    scene::OpenSettings open;
    open.cache = folder_ / elevations_path();
    open.ingest.memory = settings_.memory / 4;
    open.ingest.threads = settings_.threads;
    open.ingest.stop = settings_.stop;
    open.ingest.progress = [this](double part) {
      watch_.change([part](Progress& p) { p.ingest = std::max(p.ingest, part); });
    };
    const auto from = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point checked = from;
    open.checked = [&] {
      checked = std::chrono::steady_clock::now();
      use_.emplace(folder_, settings_.stop);
    };
    scene_ = scene::open(scene, sources, open);
    opening_ = checked - from;
    earth_ = dem::earth_of(scene_.frame);
  }

  void plan() {
    const auto plan = plan::make(scene_);
    index_.engine = slice::engine_version();
    index_.scene_name = scene_.name;
    index_.scene = digest_of(scene_);
    for (const auto& pyramid : scene_.pyramids) index_.elevations.push_back(pyramid->digest());
    index_.frame = scene_.frame;
    index_.lattice = plan.lattice;
    index_.levels = plan.levels;
    index_.planned = plan.tiles;
    index_.materials = scene_.ground.materials;
    choose_part();
    watch_.change([&](Progress& p) {
      p.phase = Progress::Phase::tiles;
      p.total = part_.size();
    });
  }

  /// Coarse levels first, so that a viewer can follow.
  void bake_tiles() {
    std::stable_sort(part_.begin(), part_.end(),
                     [](const auto& a, const auto& b) { return a.level > b.level; });
    for_each(part_, [this](const plan::Key& key) { bake_one(key); });
  }

  /// The index of what is finished, by this run or others.
  void index() {
    watch_.change([](Progress& p) { p.phase = Progress::Phase::index; });
    for_each(others_, [this](Other& other) {
      other.slice = slice::cut(scene_, index_.lattice, other.key).hash();
    });
    use_->end(
        index_, [this] { gather(); }, settings_.threads, settings_.stop);
  }

  void measure() {
    if (!settings_.stats) return;
    stats_ = measure_scene(scene_, index_.lattice, index_.planned);
    stats_->generation = opening_.count();
  }

  Report report() {
    watch_.change([this](Progress& p) {
      const auto baked = p.done - p.reused - p.cached;
      p.phase = Progress::Phase::done;
      p.total = index_.planned.size();
      p.done = index_.records.size();
      p.reused = p.done - p.cached - baked;
      p.triangles = p.bytes = 0;
      for (const auto& record : index_.records) {
        p.triangles += record.triangles;
        p.bytes += record.bytes;
      }
    });
    auto warnings = scene_.warnings;
    if (cache_ && !cache_->warning().empty()) warnings.push_back(cache_->warning());
    return {watch_.progress(), std::move(warnings), index_.complete(), stats_};
  }

 private:
  /// A tile that this run leaves to others, and looks for at its end.
  struct Other {
    plan::Key key;
    Digest slice;
  };

  void choose_part() {
    part_ = index_.planned;
    if (settings_.shard) part_ = plan::tiles_of(*settings_.shard, index_.planned);
    if (settings_.only) {
      if (!std::ranges::binary_search(index_.planned, *settings_.only)) {
        throw Error(Fault::bad_input, "--only",
                    settings_.only->text() + " is not a tile of this bake");
      }
      part_ = {*settings_.only};
    }
    std::ranges::sort(part_);
    for (const auto& key : index_.planned) {
      if (!std::ranges::binary_search(part_, key)) others_.push_back({key, {}});
    }
  }

  template <class Items, class Step>
  void for_each(Items& items, Step step) {
    tbb::task_arena arena(settings_.threads);
    arena.execute([&] {
      tbb::parallel_for_each(items.begin(), items.end(), [&](auto& item) {
        if (!settings_.stop.stop_requested()) step(item);
      });
    });
    if (settings_.stop.stop_requested()) throw_cancelled();
  }

  enum class Source { folder, cache, baked };

  void bake_one(const plan::Key& key) {
    const auto slice = slice::cut(scene_, index_.lattice, key);
    const auto hash = slice.hash();
    auto source = Source::folder;
    auto record = settings_.force ? std::nullopt : find_finished(hash, folder_);
    if (!record && cache_ && !settings_.force) {
      source = Source::cache;
      record = take_cached(hash, *cache_, folder_);
    }
    if (!record) {
      source = Source::baked;
      record = bake_tile(slice, hash, scene_.pyramids, earth_ ? &*earth_ : nullptr, folder_);
      if (cache_) add_to_cache(*record, folder_, *cache_);
    }
    watch_.change([&](Progress& p) {
      ++p.done;
      p.reused += source == Source::folder ? 1 : 0;
      p.cached += source == Source::cache ? 1 : 0;
      p.triangles += record->triangles;
      p.bytes += record->bytes;
      index_.records.push_back(*record);
      if (settings_.live_index) show_live();
    });
  }

  void gather() {
    std::mutex mutex;
    for_each(others_, [&](const Other& other) {
      auto record = find_finished(other.slice, folder_);
      if (!record) return;
      const std::lock_guard lock(mutex);
      index_.records.push_back(std::move(*record));
    });
    std::sort(index_.records.begin(), index_.records.end(),
              [](const auto& a, const auto& b) { return a.key < b.key; });
  }

  /// Rewrites the index of the tiles so far.
  void show_live() {
    const auto now = std::chrono::steady_clock::now();
    if (index_.complete() || now - shown_ < *settings_.live_index) return;
    shown_ = now;
    tileset::write_index(index_, tileset::estimate_errors(index_), folder_);
  }

  const fs::path& folder_;
  const Settings& settings_;
  Watch watch_;
  std::optional<FolderInUse> use_;
  std::unique_ptr<store::Cache> cache_;
  scene::Scene scene_;
  std::optional<dem::Earth> earth_;
  std::vector<plan::Key> part_;  // this run's to bake
  std::vector<Other> others_;
  tileset::Bake index_;  // its records grow under the watch's lock
  std::chrono::steady_clock::time_point shown_{};
  std::chrono::duration<double> opening_{};
  std::optional<Statistics> stats_;
};

}  // namespace

Report run(const json& scene, const scene::Sources& sources, const fs::path& folder,
           const Settings& settings) {
  Run run(folder, settings);
  run.open(scene, sources);  // elevations in the scene frame, every value resolved
  run.plan();                // tile keys
  run.bake_tiles();          // each: slice, field, volume, surface, lod, glb, store
  run.index();               // measured errors, tilesets, bake.json
  run.measure();             // if asked: the figures of a scene
  return run.report();
}

}  // namespace hoodoo::bake
