#include "tiling/bake/merge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>

#include <algorithm>
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
#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::bake {
namespace {

namespace fs = std::filesystem;

/// What the index of a part says of the whole; its tiles are read when they are wanted.
struct Part {
  fs::path folder;
  tileset::Header header;
  std::size_t planned = 0;
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
std::vector<std::pair<std::string, std::string>> traits(const Part& part) {
  const auto& bake = part.header;
  const auto& frame = bake.frame;
  return {{"engine", bake.engine},
          {"scene's name", bake.scene_name},
          {"frame", fmt::format("{} ({} m) at {}, {} {}", frame.crs, frame.unit, frame.origin_x,
                                frame.origin_y, frame.vertical)},
          {"spacing", fmt::format("{} m", bake.lattice.spacing0)},
          {"step", fmt::format("{} m", bake.lattice.step0)},
          {"cells of a tile", std::to_string(bake.lattice.tile_cells)},
          {"levels", std::to_string(bake.levels)},
          {"finer sampling of levels", fmt::format("{}", fmt::join(bake.lattice.finer, ", "))},
          {"materials", text_of(bake.materials)},
          {"elevations", text_of(bake.elevations)},
          {"number of planned tiles", std::to_string(part.planned)}};
}

void compare(const Part& part, const Part& first, std::vector<Problem>& problems) {
  const auto before = problems.size();
  const auto where = (part.folder / "bake.json").string();
  const auto mine = traits(part), others = traits(first);
  for (std::size_t i = 0; i < mine.size(); ++i) {
    if (mine[i].second == others[i].second) continue;
    problems.push_back({where, fmt::format("is of another bake than {}: its {} is {}, not {}",
                                           first.folder.string(), mine[i].first, mine[i].second,
                                           others[i].second)});
  }
  if (problems.size() > before) return;
  if (part.header.scene == first.header.scene) return;
  problems.push_back({where, fmt::format("is of another scene than {}: its operations, geology or "
                                         "bake settings are not the same",
                                         first.folder.string())});
}

Part read_part(const fs::path& folder) {
  const auto where = (folder / "bake.json").string();
  const tileset::ManifestReader reader(folder);
  return {folder, tileset::read_header(reader, where),
          tileset::count_of(reader.document(), "planned", where)};
}

std::vector<Part> read_parts(const std::vector<fs::path>& folders, const fs::path& into) {
  std::vector<Part> parts;
  std::vector<Problem> problems;
  for (const auto& folder : folders) {
    if (!fs::is_regular_file(folder / "bake.json")) {
      throw Error(Fault::not_found, folder.string(),
                  "has no bake.json: it is no bake, or its run has not ended yet");
    }
    parts.push_back(read_part(folder));
  }
  if (fs::is_regular_file(into / "bake.json")) parts.push_back(read_part(into));
  for (const auto& part : parts) compare(part, parts.front(), problems);
  if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
  return parts;
}

/// The tiles of the plan, one part after another: those that any part has are finished, and `mark`
/// names their record.
class Collection {
 public:
  explicit Collection(const std::vector<Part>& parts) {
    tiles_.reserve(parts.front().planned);
    for (const auto& part : parts) add(part, parts.front());
    if (!problems_.empty()) throw Error(Fault::bad_input, std::move(problems_));
  }
  std::vector<plan::Tile> take() { return std::move(tiles_); }

 private:
  void add(const Part& part, const Part& first) {
    const auto where = (part.folder / "bake.json").string();
    tileset::ManifestReader reader(part.folder);
    std::size_t place = 0;
    for (; const auto entry = reader.next(); ++place) {
      if (&part == &first) tiles_.emplace_back(entry->key);
      if (place == tiles_.size() || tiles_[place].key() != entry->key) {
        throw Error(Fault::bad_input, where,
                    fmt::format("is of another scene than {}: other tiles are planned",
                                first.folder.string()));
      }
      if (!entry->missing) add(tiles_[place], entry->record, where);
    }
    tileset::expect_all_planned(place, reader, where);
  }

  void add(plan::Tile& tile, const tileset::Record& record, const std::string& where) {
    const auto mark = sha256(tileset::to_json(record).dump()).start();
    if (tile.finished && (tile.slice != record.slice || tile.mark != mark)) {
      problems_.push_back(
          {where, "has another tile " + record.key.text() + " than a folder before it"});
      return;
    }
    tile.finished = true;
    tile.empty = record.empty;
    tile.slice = record.slice;
    tile.mark = mark;
  }

  std::vector<plan::Tile> tiles_;
  std::vector<Problem> problems_;
};

/// Copies what is the same in every bake of the scene, and is missing in `into`.
void copy_elevations(const std::vector<Part>& parts, const fs::path& into,
                     const std::stop_token& stop) {
  for (const auto& digest : parts.front().header.elevations) {
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

/// Copies tiles, each from the first part that has it undamaged.
class Copying {
 public:
  Copying(std::span<plan::Tile> tiles, const fs::path& into, const MergeSettings& settings)
      : tiles_(tiles), into_(into), settings_(settings) {
    for (auto& tile : tiles_) tile.ours = tile.finished;  // still to be copied
  }

  std::uint64_t run(const std::vector<Part>& parts) {
    for (const auto& part : parts) {
      tileset::ManifestReader reader(part.folder);
      for (bool more = true; more;) more = copy_some(part, reader);
    }
    std::vector<Problem> problems;
    for (const auto& [key, error] : damaged_) {
      problems.insert(problems.end(), error.problems.begin(), error.problems.end());
    }
    std::ranges::sort(problems, {}, &Problem::where);
    if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
    return copied_;
  }

 private:
  /// False at the part's end.
  bool copy_some(const Part& part, tileset::ManifestReader& reader) {
    constexpr std::size_t at_once = 1024;
    std::vector<tileset::Record> records;
    bool more = true;
    while (more && records.size() < at_once) {
      auto entry = reader.next();
      more = entry.has_value();
      if (!more || entry->missing || !plan::find(tiles_, entry->key)->ours) continue;
      records.push_back(std::move(entry->record));
    }
    tbb::task_arena arena(settings_.threads);
    arena.execute([&] {
      tbb::parallel_for_each(records.begin(), records.end(), [&](const tileset::Record& record) {
        if (!settings_.stop.stop_requested()) copy(part, record);
      });
    });
    if (settings_.stop.stop_requested()) throw Error(Fault::cancelled, "", "stopped");
    return more;
  }

  void copy(const Part& part, const tileset::Record& record) {
    const bool is_new = find_finished(record.slice, into_) != record;
    try {
      for (const auto& file : record.files()) {
        store::put_tile(into_, store::get_tile(part.folder, file.content));
      }
    } catch (const Error& error) {
      if (error.fault != Fault::bad_input && error.fault != Fault::not_found) throw;
      const std::lock_guard lock(mutex_);
      damaged_.insert_or_assign(record.key, error);
      return;
    }
    if (is_new) {
      write_file(into_ / record_path(record.slice), tileset::to_json(record).dump());
    }
    const std::lock_guard lock(mutex_);
    plan::find(tiles_, record.key)->ours = false;
    copied_ += is_new ? 1 : 0;
    damaged_.erase(record.key);
  }

  std::span<plan::Tile> tiles_;
  const fs::path& into_;
  const MergeSettings& settings_;
  std::mutex mutex_;
  std::uint64_t copied_ = 0;
  std::map<plan::Key, Error> damaged_;  // in all parts so far
};

}  // namespace

MergeReport merge(const std::vector<fs::path>& folders, const fs::path& into,
                  const MergeSettings& settings) {
  const auto parts = read_parts(folders, into);
  tileset::Index index;
  static_cast<tileset::Header&>(index) = parts.front().header;
  index.tiles = Collection(parts).take();
  index.read = [&into](const plan::Tile& tile) { return read_record(into, tile.slice); };
  FolderInUse use(into, settings.stop);
  copy_elevations(parts, into, settings.stop);
  MergeReport report;
  report.copied = Copying(index.tiles, into, settings).run(parts);
  report.tiles = index.finished();
  for (const auto& tile : index.tiles) {
    if (!tile.finished) report.missing.push_back(tile.key());
  }
  use.end(
      index, {}, [] {}, settings.threads, settings.stop);
  return report;
}

}  // namespace hoodoo::bake
