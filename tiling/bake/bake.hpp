#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/scene/scene.hpp"
#include "tiling/bake/stats.hpp"
#include "tiling/plan/plan.hpp"

/// tiling/bake: all stages in order. Read bake.cpp first.
namespace hoodoo::bake {

/// A tile that is finished and not empty.
struct FinishedTile {
  plan::Key key;
  Box box;  // of surface and skirt [m], scene frame
};

/// How far a bake is.
struct Progress {
  enum class Phase { ingest, tiles, index, done } phase = Phase::ingest;
  double ingest = 0;                  // fraction
  std::uint64_t done = 0, total = 0;  // tiles: of this run; once it is done, of the whole bake
  std::uint64_t reused = 0;           // of `done`, those found finished, here or in Settings::reuse
  std::uint64_t cached = 0;           // of `done`, those taken from the cache
  std::uint64_t triangles = 0, bytes = 0;
  std::vector<FinishedTile> finished;  // since the report before
};

struct Settings {
  int threads = 1;
  std::size_t memory = std::size_t{1024} << 20;  // [bytes]
  std::optional<plan::Key> only;                 // bake this tile alone,
  std::optional<plan::Shard> shard;              // or this part of the plan alone
  bool plan_only = false;                        // ingest and plan, and bake nothing
  std::optional<std::uint64_t> most_tiles;       // a plan of more is a limit
  std::optional<double> most_extent;             // and so is a longer side of the world [m]
  bool stats = false;                            // measure the scene, too
  bool force = false;                            // bake tiles again that are finished
  /// Finished tiles of any bakes, shared with others; empty: none. See store::Cache.
  std::filesystem::path cache;
  /// The folder of an earlier bake: its tiles and elevations are taken where they would be the
  /// same; empty: none.
  std::filesystem::path reuse;
  std::stop_token stop;
  /// Called from any thread, not at the same time twice.
  std::function<void(const Progress&)> progress;
  /// Index what is finished this often while tiles are baked, so that a viewer can follow.
  std::optional<std::chrono::milliseconds> live_index;
};

/// What a plan is.
struct Planned {
  std::vector<std::uint64_t> tiles;  // of each level, the finest first
  std::size_t memory = 0;            // held for all of them until the bake is done [bytes]
};

struct Report {
  Progress progress;
  std::vector<std::string> warnings;
  bool complete = false;  // every planned tile is there
  std::optional<Statistics> stats;
  std::optional<Planned> plan;  // where that was all that was asked for
};

/// Bakes `scene` (JSON, with files as `sources` allows) into `folder`. What is finished there from
/// an earlier run, killed or not, with the same slices is taken over; after an edit only tiles
/// whose slices changed are baked, and files that no tile needs any more are removed once the index
/// is swapped. Several runs, in any processes, may bake into one folder at once; each ends with an
/// index of all that is finished then. The bytes of every file depend on the scene, its elevations
/// and the engine's release alone.
/// Errors: bad_input, not_found, limit, io, cancelled.
Report run(const nlohmann::json& scene, const scene::Sources& sources,
           const std::filesystem::path& folder, const Settings& settings);

}  // namespace hoodoo::bake
