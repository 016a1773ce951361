#include "tiling/bake/bake.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
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
    progress_.finished.clear();
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
  std::vector<Digest> balls;
  const auto named = tree::without_balls(scene.ground, balls);
  json all = {
      {"engine", slice::engine_version()},
      {"frame", {scene.frame.crs, scene.frame.origin_x, scene.frame.origin_y}},
      {"spacing", scene.spacing},
      {"profile", scene.bake.profile},
      {"simplify", {scene.bake.simplify, scene.bake.simplify_coarse}},
      {"tile_cells", scene.bake.tile_cells},
      {"world", {scene.extent.min.x, scene.extent.min.y, scene.extent.max.x, scene.extent.max.y}},
      {"ground", tree::to_json(named)},
      {"pyramids", json::array()}};
  for (const auto& pyramid : scene.pyramids) all["pyramids"].push_back(pyramid->digest().hex());
  for (const auto& list : balls) all["balls"].push_back(list.hex());
  if (scene.floor) all["floor"] = *scene.floor;
  if (scene.bake.draco_speed != 5) all["draco_speed"] = scene.bake.draco_speed;
  if (scene.bake.keep_thin) all["keep_thin"] = true;
  if (scene.bake.tile_triangles != scene::BakeSettings::default_tile_triangles) {
    all["tile_triangles"] = scene.bake.tile_triangles;
  }
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
    open.ball_memory = settings_.memory / 16;
    open.ingest.threads = settings_.threads;
    open.ingest.stop = settings_.stop;
    open.ingest.progress = [this](double part) {
      watch_.change([part](Progress& p) { p.ingest = std::max(p.ingest, part); });
    };
    using Clock = std::chrono::steady_clock;
    const auto from = Clock::now();
    auto checked = from, ingested = from;
    open.checked = [&] {
      checked = Clock::now();
      use_.emplace(folder_, settings_.stop);
      if (!settings_.reuse.empty()) share_elevations(settings_.reuse, folder_, settings_.stop);
    };
    open.ingested = [&] { ingested = Clock::now(); };
    scene_ = scene::open(scene, sources, open);
    check_extent();
    opening_ = (checked - from) + (Clock::now() - ingested);
    earth_ = dem::earth_of(scene_.frame);
  }

  void plan() {
    auto plan = plan::make(scene_);
    if (settings_.most_tiles && plan.tiles.size() > *settings_.most_tiles) {
      throw Error(Fault::limit, "/bake/spacing",
                  fmt::format("{} m gives {} tiles, the limit is {}", scene_.spacing,
                              plan.tiles.size(), *settings_.most_tiles));
    }
    index_.engine = slice::engine_version();
    index_.scene_name = scene_.name;
    index_.scene = digest_of(scene_);
    for (const auto& pyramid : scene_.pyramids) index_.elevations.push_back(pyramid->digest());
    index_.frame = scene_.frame;
    index_.lattice = plan.lattice;
    index_.levels = plan.levels;
    index_.tiles = std::move(plan.tiles);
    index_.read = [this](const plan::Tile& tile) { return read_record(folder_, tile.slice); };
    index_.materials = scene_.ground.materials;
    choose_part();
    watch_.change([&](Progress& p) {
      p.phase = Progress::Phase::tiles;
      p.total = part_;
    });
  }

  /// Coarse levels first, so that a viewer can follow.
  void bake_tiles() {
    for_each([this](plan::Tile& tile) {
      if (tile.ours) bake_one(tile);
    });
  }

  /// The index of what is finished, by this run or others.
  void index() {
    watch_.change([](Progress& p) { p.phase = Progress::Phase::index; });
    for_each([this](plan::Tile& tile) {
      if (!tile.ours) tile.slice = slice::cut(scene_, index_.lattice, tile.key()).hash();
    });
    written_ = use_->end(
        index_, scene_.ball_files, [this] { gather(); }, settings_.threads, settings_.stop);
  }

  /// What the plan is, instead of a bake.
  Report plan_report() {
    watch_.change([this](Progress& p) {
      p.phase = Progress::Phase::done;
      p.total = index_.tiles.size();
    });
    Planned planned{{}, index_.tiles.capacity() * sizeof(plan::Tile)};
    for (const auto& tile : index_.tiles) {
      planned.tiles.resize(static_cast<std::size_t>(tile.level) + 1);
      ++planned.tiles.back();
    }
    return {watch_.progress(), scene_.warnings, false, std::nullopt, planned};
  }

  void measure() {
    if (!settings_.stats) return;
    stats_ = measure_scene(scene_, index_.lattice, index_.tiles);
    stats_->generation = opening_.count();
  }

  Report report() {
    watch_.change([this](Progress& p) {
      const auto baked = p.done - p.reused - p.cached;
      p.phase = Progress::Phase::done;
      p.total = index_.tiles.size();
      p.done = written_.tiles;
      p.reused = p.done - p.cached - baked;
      p.triangles = written_.triangles;
      p.bytes = written_.bytes;
    });
    auto warnings = scene_.warnings;
    if (cache_ && !cache_->warning().empty()) warnings.push_back(cache_->warning());
    return {watch_.progress(), std::move(warnings), index_.complete(), stats_, std::nullopt};
  }

 private:
  void check_extent() const {
    const auto& [least, most] = scene_.extent;
    const double side = std::max(most.x - least.x, most.y - least.y);
    if (!settings_.most_extent || side <= *settings_.most_extent) return;
    throw Error(Fault::limit, "/bake/extent",
                fmt::format("the longest side of the world is {} m, the limit is {} m", side,
                            *settings_.most_extent));
  }
  void choose_part() {
    auto& tiles = index_.tiles;
    if (settings_.shard) {
      plan::choose(*settings_.shard, tiles);
    } else if (settings_.only) {
      auto* only = plan::find(std::span<plan::Tile>(tiles), *settings_.only);
      if (only == nullptr) {
        throw Error(Fault::bad_input, "--only",
                    settings_.only->text() + " is not a tile of this bake");
      }
      only->ours = true;
    } else {
      for (auto& tile : tiles) tile.ours = true;
    }
    part_ = static_cast<std::size_t>(std::ranges::count(tiles, true, &plan::Tile::ours));
  }

  /// Calls `step` for all tiles, the coarsest level first, from all threads: whichever is free
  /// takes the next one, so that none begins with fine tiles while coarse ones wait.
  template <class Step>
  void for_each(Step step) {
    auto& tiles = index_.tiles;
    std::atomic<std::size_t> left = tiles.size();
    tbb::task_arena arena(settings_.threads);
    arena.execute([&] {
      tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t) {
        auto& next = tiles[--left];
        if (!settings_.stop.stop_requested()) step(next);
      });
    });
    if (settings_.stop.stop_requested()) throw_cancelled();
  }

  enum class Source { folder, cache, baked };

  void bake_one(plan::Tile& tile) {
    const auto slice = slice::cut(scene_, index_.lattice, tile.key());
    const auto hash = slice.hash();
    auto source = Source::folder;
    auto record = settings_.force ? std::nullopt : find_finished(hash, folder_);
    if (!record && !settings_.reuse.empty() && !settings_.force) {
      record = share_finished(hash, settings_.reuse, folder_);
    }
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
      if (!record->empty) p.finished.push_back({tile.key(), record->box});
      tile.slice = hash;
      tile.finished = true;
      tile.empty = record->empty;
      if (settings_.live_index) show_live();
    });
  }

  void gather() {
    for_each([&](plan::Tile& tile) {
      if (tile.ours) return;
      const auto record = find_finished(tile.slice, folder_);
      tile.finished = record.has_value();
      tile.empty = record && record->empty;
    });
  }

  /// Rewrites the index of the tiles so far, for a tenth of the time at most.
  void show_live() {
    const auto now = std::chrono::steady_clock::now();
    if (now < show_next_ || index_.complete()) return;
    tileset::estimate_errors(index_);
    tileset::write_index(index_, folder_);
    const auto end = std::chrono::steady_clock::now();
    show_next_ = end + std::max<std::chrono::steady_clock::duration>(*settings_.live_index,
                                                                     10 * (end - now));
  }

  const fs::path& folder_;
  const Settings& settings_;
  Watch watch_;
  std::optional<FolderInUse> use_;
  std::unique_ptr<store::Cache> cache_;
  scene::Scene scene_;
  std::optional<dem::Earth> earth_;
  std::size_t part_ = 0;  // how many tiles are this run's to bake
  tileset::Index index_;  // what is finished is noted under the watch's lock
  tileset::Written written_;
  std::chrono::steady_clock::time_point show_next_{};
  std::chrono::duration<double> opening_{};
  std::optional<Statistics> stats_;
};

}  // namespace

Report run(const json& scene, const scene::Sources& sources, const fs::path& folder,
           const Settings& settings) {
  Run run(folder, settings);
  run.open(scene, sources);  // elevations in the scene frame, every value resolved
  run.plan();                // tile keys
  if (settings.plan_only) return run.plan_report();
  run.bake_tiles();  // each: slice, field, volume, surface, lod, glb, store
  run.index();       // measured errors, tilesets, bake.json
  run.measure();     // if asked: the figures of a scene
  return run.report();
}

}  // namespace hoodoo::bake
