#include "tiling/bake/bake.hpp"

#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/base/error.hpp"
#include "tiling/bake/tile.hpp"
#include "tiling/slice/slice.hpp"
#include "tiling/store/store.hpp"
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
  json all = {{"engine", slice::engine_version()},
              {"frame", {scene.frame.crs, scene.frame.origin_x, scene.frame.origin_y}},
              {"spacing", scene.spacing},
              {"profile", scene.bake.profile},
              {"simplify", {scene.bake.simplify, scene.bake.simplify_coarse}},
              {"tile_cells", scene.bake.tile_cells},
              {"ground", tree::to_json(scene.ground)},
              {"pyramids", json::array()}};
  for (const auto& pyramid : scene.pyramids) all["pyramids"].push_back(pyramid->digest().hex());
  return sha256(all.dump());
}

/// One run: the state its steps share.
class Run {
 public:
  Run(const fs::path& folder, const Settings& settings)
      : folder_(folder), settings_(settings), watch_(settings) {}

  void open(const json& scene, const scene::Sources& sources) {
    scene::OpenSettings open;
    open.cache = folder_ / ".hoodoo" / "elevations";
    open.ingest.memory = settings_.memory / 4;
    open.ingest.threads = settings_.threads;
    open.ingest.stop = settings_.stop;
    open.ingest.progress = [this](double part) {
      watch_.change([part](Progress& p) { p.ingest = std::max(p.ingest, part); });
    };
    scene_ = scene::open(scene, sources, open);
  }

  void plan() {
    const auto plan = plan::make(scene_);
    index_.engine = slice::engine_version();
    index_.scene_name = scene_.name;
    index_.scene = digest_of(scene_);
    index_.frame = scene_.frame;
    index_.lattice = plan.lattice;
    index_.levels = plan.levels;
    index_.planned = plan.tiles;
    index_.materials = scene_.ground.materials;
    if (settings_.only &&
        !std::binary_search(plan.tiles.begin(), plan.tiles.end(), *settings_.only)) {
      throw Error(Fault::bad_input, "--only",
                  settings_.only->text() + " is not a tile of this bake");
    }
    watch_.change([&](Progress& p) {
      p.phase = Progress::Phase::tiles;
      p.total = plan.tiles.size();
    });
  }

  /// Coarse levels first, so that a viewer can follow.
  void bake_tiles() {
    auto order = index_.planned;
    std::stable_sort(order.begin(), order.end(),
                     [](const auto& a, const auto& b) { return a.level > b.level; });
    tbb::task_arena arena(settings_.threads);
    arena.execute([&] {
      tbb::parallel_for_each(order.begin(), order.end(),
                             [this](const plan::Key& key) { bake_one(key); });
    });
    if (settings_.stop.stop_requested()) throw_cancelled();
    std::sort(index_.records.begin(), index_.records.end(),
              [](const auto& a, const auto& b) { return a.key < b.key; });
  }

  /// The index of what is finished; `sweep` removes what it does not name.
  void index(bool sweep) {
    const auto errors = tileset::measure_errors(index_, folder_, settings_.threads, settings_.stop);
    auto files = tileset::write_index(index_, errors, folder_);
    if (!sweep) return;
    std::set<fs::path> keep(files.begin(), files.end());
    for (const auto& record : index_.records) keep.insert(record_path(record.slice));
    for (const auto& pyramid : scene_.pyramids) {
      keep.insert(fs::path(".hoodoo") / "elevations" / pyramid->digest().hex());
    }
    store::sweep(folder_, keep);
  }

  Report report() {
    watch_.change([](Progress& p) { p.phase = Progress::Phase::done; });
    return {watch_.progress(), scene_.warnings, complete()};
  }
  bool complete() const { return index_.records.size() == index_.planned.size(); }
  void announce_index() {
    watch_.change([](Progress& p) { p.phase = Progress::Phase::index; });
  }

 private:
  void bake_one(const plan::Key& key) {
    if (settings_.stop.stop_requested()) return;
    const auto slice = slice::cut(scene_, index_.lattice, key);
    const auto hash = slice.hash();
    const bool wanted = !settings_.only || *settings_.only == key;
    auto record = settings_.force && wanted ? std::nullopt : find_finished(hash, folder_);
    const bool reused = record.has_value();
    if (!record) {
      if (!wanted) return;
      record = bake_tile(slice, hash, scene_.pyramids, folder_);
    }
    watch_.change([&](Progress& p) {
      ++p.done;
      p.reused += reused ? 1 : 0;
      p.triangles += record->triangles;
      p.bytes += record->bytes;
      index_.records.push_back(*record);
      if (settings_.live_index) show_live();
    });
  }

  /// Rewrites the index of the tiles so far. Their errors are estimates, which a complete index,
  /// whose errors a later one may take over, never holds.
  void show_live() {
    const auto now = std::chrono::steady_clock::now();
    if (complete() || now - shown_ < *settings_.live_index) return;
    shown_ = now;
    std::map<plan::Key, double> errors;
    for (const auto& key : index_.planned) {
      errors[key] = key.level == 0 ? 0 : index_.lattice.spacing(key.level);
    }
    tileset::write_index(index_, errors, folder_);
  }

  const fs::path& folder_;
  const Settings& settings_;
  Watch watch_;
  scene::Scene scene_;
  tileset::Bake index_;  // its records grow under the watch's lock
  std::chrono::steady_clock::time_point shown_{};
};

}  // namespace

Report run(const json& scene, const scene::Sources& sources, const fs::path& folder,
           const Settings& settings) {
  Run run(folder, settings);
  run.open(scene, sources);  // elevations in the scene frame, every value resolved
  run.plan();                // tile keys
  run.bake_tiles();          // each: slice, field, volume, surface, lod, glb, store
  run.announce_index();
  run.index(run.complete());  // measured errors, tilesets, bake.json
  return run.report();
}

}  // namespace hoodoo::bake
