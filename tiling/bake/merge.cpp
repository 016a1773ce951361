#include "tiling/bake/merge.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "tiling/bake/folder.hpp"
#include "tiling/bake/tile.hpp"
#include "tiling/store/store.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::bake {
namespace {

namespace fs = std::filesystem;

struct Part {
  fs::path folder;
  tileset::Bake bake;
};

/// One tile, and the folders that have it.
struct Tile {
  tileset::Record record;
  std::vector<const Part*> parts;
};

std::string text_of(const std::vector<Digest>& digests) {
  std::string text;
  for (const auto& digest : digests) text += digest.hex().substr(0, 12) + " ";
  return text;
}

std::string text_of(const std::vector<tree::Material>& materials) {
  std::string text;
  for (const auto& m : materials) {
    text += fmt::format("{} [{}, {}] {} {}/{}/{}; ", m.name, m.low, m.high, m.friction, m.color[0],
                        m.color[1], m.color[2]);
  }
  return text;
}

/// What must be equal in all parts, by name, as text to compare and to show.
std::vector<std::pair<std::string, std::string>> traits(const tileset::Bake& bake) {
  const auto& frame = bake.frame;
  return {{"engine", bake.engine},
          {"scene's name", bake.scene_name},
          {"frame", fmt::format("{} ({} m) at {}, {} {}", frame.crs, frame.unit, frame.origin_x,
                                frame.origin_y, frame.vertical)},
          {"spacing", fmt::format("{} m", bake.lattice.spacing0)},
          {"step", fmt::format("{} m", bake.lattice.step0)},
          {"cells of a tile", std::to_string(bake.lattice.tile_cells)},
          {"levels", std::to_string(bake.levels)},
          {"materials", text_of(bake.materials)},
          {"elevations", text_of(bake.elevations)},
          {"number of planned tiles", std::to_string(bake.planned.size())}};
}

void compare(const Part& part, const Part& first, std::vector<Problem>& problems) {
  const auto before = problems.size();
  const auto where = (part.folder / "bake.json").string();
  const auto mine = traits(part.bake), others = traits(first.bake);
  for (std::size_t i = 0; i < mine.size(); ++i) {
    if (mine[i].second == others[i].second) continue;
    problems.push_back({where, fmt::format("is of another bake than {}: its {} is {}, not {}",
                                           first.folder.string(), mine[i].first, mine[i].second,
                                           others[i].second)});
  }
  if (problems.size() > before) return;
  const auto differs = [&](const char* what) {
    problems.push_back(
        {where, fmt::format("is of another scene than {}: {}", first.folder.string(), what)});
  };
  if (part.bake.planned != first.bake.planned) {
    differs("other tiles are planned");
  } else if (part.bake.scene != first.bake.scene) {
    differs("its operations, geology or bake settings are not the same");
  }
}

std::vector<Part> read_parts(const std::vector<fs::path>& folders, const fs::path& into) {
  std::vector<Part> parts;
  std::vector<Problem> problems;
  for (const auto& folder : folders) {
    if (!fs::is_regular_file(folder / "bake.json")) {
      throw Error(Fault::not_found, folder.string(),
                  "has no bake.json: it is no bake, or its run has not ended yet");
    }
    parts.push_back({folder, tileset::read_bake(folder)});
  }
  if (fs::is_regular_file(into / "bake.json")) parts.push_back({into, tileset::read_bake(into)});
  for (const auto& part : parts) compare(part, parts.front(), problems);
  if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
  return parts;
}

std::vector<Tile> collect(const std::vector<Part>& parts) {
  std::map<plan::Key, Tile> tiles;
  std::vector<Problem> problems;
  for (const auto& part : parts) {
    for (const auto& record : part.bake.records) {
      auto& tile = tiles.try_emplace(record.key, Tile{record, {}}).first->second;
      tile.parts.push_back(&part);
      if (tile.record == record) continue;
      problems.push_back({(part.folder / "bake.json").string(),
                          fmt::format("has another tile {} than {}", record.key.text(),
                                      tile.parts.front()->folder.string())});
    }
  }
  if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
  std::vector<Tile> all;
  for (auto& [key, tile] : tiles) all.push_back(std::move(tile));
  return all;
}

/// Copies what is the same in every bake of the scene, and is missing in `into`.
void copy_elevations(const std::vector<Part>& parts, const fs::path& into,
                     const std::stop_token& stop) {
  for (const auto& digest : parts.front().bake.elevations) {
    const auto place = elevations_path() / digest.hex();
    const FileLock lock(into / (place.string() + ".lock"), FileLock::Kind::exclusive, stop);
    if (fs::exists(into / place / "pyramid.json")) continue;
    for (const auto& part : parts) {
      if (!fs::exists(part.folder / place / "pyramid.json")) continue;
      const auto unfinished = into / (place.string() + ".part");
      std::error_code error;
      fs::remove_all(unfinished, error);
      fs::copy(part.folder / place, unfinished, fs::copy_options::recursive, error);
      if (!error) fs::rename(unfinished, into / place, error);
      if (error) throw Error(Fault::io, (into / place).string(), error.message());
      break;
    }
  }
}

/// Copies a tile from the first part that has it undamaged. True if it was not there.
bool copy(const Tile& tile, const fs::path& into) {
  const bool is_new = find_finished(tile.record.slice, into) != tile.record;
  const auto record = into / record_path(tile.record.slice);
  std::optional<Error> damaged;
  for (const auto* part : tile.parts) {
    try {
      if (!tile.record.empty) {
        store::put_tile(into, store::get_tile(part->folder, tile.record.content));
      }
      if (is_new) write_file(record, tileset::to_json(tile.record).dump());
      return is_new;
    } catch (const Error& error) {
      if (error.fault != Fault::bad_input && error.fault != Fault::not_found) throw;
      damaged = error;
    }
  }
  throw Error(*damaged);
}

std::uint64_t copy_all(const std::vector<Tile>& tiles, const fs::path& into,
                       const MergeSettings& settings) {
  std::atomic<std::uint64_t> copied = 0;
  std::vector<Problem> damaged;
  std::mutex mutex;
  tbb::task_arena arena(settings.threads);
  arena.execute([&] {
    tbb::parallel_for_each(tiles.begin(), tiles.end(), [&](const Tile& tile) {
      if (settings.stop.stop_requested()) return;
      try {
        copied += copy(tile, into) ? 1 : 0;
      } catch (const Error& error) {
        if (error.fault != Fault::bad_input && error.fault != Fault::not_found) throw;
        const std::lock_guard lock(mutex);
        damaged.insert(damaged.end(), error.problems.begin(), error.problems.end());
      }
    });
  });
  if (settings.stop.stop_requested()) throw Error(Fault::cancelled, "", "stopped");
  std::ranges::sort(damaged, {}, &Problem::where);
  if (!damaged.empty()) throw Error(Fault::bad_input, std::move(damaged));
  return copied;
}

std::vector<plan::Key> missing_of(const tileset::Bake& bake) {
  std::vector<plan::Key> missing, finished;
  for (const auto& record : bake.records) finished.push_back(record.key);
  std::ranges::set_difference(bake.planned, finished, std::back_inserter(missing));
  return missing;
}

}  // namespace

MergeReport merge(const std::vector<fs::path>& folders, const fs::path& into,
                  const MergeSettings& settings) {
  const auto parts = read_parts(folders, into);
  const auto tiles = collect(parts);
  FolderInUse use(into, settings.stop);
  copy_elevations(parts, into, settings.stop);
  MergeReport report;
  report.copied = copy_all(tiles, into, settings);
  auto bake = parts.front().bake;
  bake.records.clear();
  for (const auto& tile : tiles) bake.records.push_back(tile.record);
  use.end(
      bake, [] {}, settings.threads, settings.stop);
  report.tiles = bake.records.size();
  report.missing = missing_of(bake);
  return report;
}

}  // namespace hoodoo::bake
