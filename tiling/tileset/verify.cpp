#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "tiling/glb/earth.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/store/store.hpp"
#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/seams.hpp"

namespace hoodoo::tileset {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Problems are listed up to this many, and counted on.
constexpr std::size_t most_problems = 200;

class Report {
 public:
  void add(std::string where, std::string what) {
    if (++count_ <= most_problems) problems_.push_back({std::move(where), std::move(what)});
  }
  std::vector<Problem> take() {
    if (count_ > most_problems) {
      problems_.push_back({"", fmt::format("and {} more", count_ - most_problems)});
    }
    return std::move(problems_);
  }

 private:
  std::vector<Problem> problems_;
  std::size_t count_ = 0;
};

/// Walks tileset.json and the files it names.
class IndexWalk {
 public:
  IndexWalk(const fs::path& folder, Report& report) : folder_(folder), report_(report) {}

  /// Box in force for each tile file, by relative path.
  std::map<fs::path, Box> run() {
    try {
      open("tileset.json", nullptr);
    } catch (const json::exception& error) {
      throw Error(Fault::bad_input, (folder_ / "tileset.json").string(),
                  std::string("is no tileset: ") + error.what());
    }
    return std::move(contents_);
  }

 private:
  struct Tile {
    Box box;
    double error;
  };

  void open(const fs::path& path, const Tile* pointing) {
    const std::string where = (folder_ / path).string();
    if (!opened_.insert(path).second) return report_.add(where, "is named twice");
    const JsonLimits limits{.bytes = 256U << 20, .depth = 64, .values = 50'000'000};
    const json document = parse_json(read_file(folder_ / path, limits.bytes), where, limits);
    if (!document.is_object() || !document.contains("root")) {
      throw Error(Fault::bad_input, where, "is no tileset");
    }
    if (number_of(document, "geometricError", where) <
        number_of(document.at("root"), "geometricError", where)) {
      report_.add(where, "has a smaller geometricError than its root");
    }
    visit(document.at("root"), path, pointing, true);
  }

  Box box_of(const json& tile, const std::string& where) const {
    const json volume = tile.value("boundingVolume", json::object());
    const json numbers = volume.is_object() ? volume.value("box", json::array()) : json::array();
    if (!numbers.is_array() || numbers.size() != 12) {
      throw Error(Fault::bad_input, where, "has a tile without a box");
    }
    double v[12];
    for (std::size_t i = 0; i < 12; ++i) {
      if (!numbers.at(i).is_number())
        throw Error(Fault::bad_input, where, "has a box of no numbers");
      v[i] = numbers.at(i).get<double>();
    }
    const Vec3 middle{v[0], v[1], v[2]}, half{v[3], v[7], v[11]};
    return {middle - half, middle + half};
  }

  /// `above`: the tile whose child this is, or that points at this file.
  void visit(const json& tile, const fs::path& path, const Tile* above, bool root) {
    const std::string where = (folder_ / path).string();
    const Tile here{box_of(tile, where), number_of(tile, "geometricError", where)};
    if (above != nullptr) {
      if (!above->box.contains(here.box)) report_.add(where, "a box leaves its parent's");
      if (root ? here.error != above->error : !(here.error < above->error)) {
        report_.add(where, fmt::format("geometricError {} does not fall from {}", here.error,
                                       above->error));
      }
    }
    if (tile.contains("content")) {
      const auto uri = text_of(tile.at("content"), "uri", where);
      const auto target = (path.parent_path() / uri).lexically_normal();
      if (target.is_absolute() || *target.begin() == "..") {
        report_.add(where, "names a file outside: " + uri);
      } else if (target.extension() == ".json") {
        open(target, &here);
      } else if (!contents_.emplace(target, here.box).second) {
        report_.add(where, "names a file twice: " + uri);
      }
    }
    if (!tile.contains("children")) return;
    for (const auto& child : tile.at("children")) visit(child, path, &here, false);
  }

  const fs::path& folder_;
  Report& report_;
  std::set<fs::path> opened_;
  std::map<fs::path, Box> contents_;
};

Box bounds(const glb::Decoded& tile) {
  Box box;
  for (const auto* part : {&tile.surface, &tile.skirt}) {
    for (const auto& p : part->points) {
      const auto at = [&](std::size_t a) {
        return static_cast<double>(tile.origin[a] + p[a]) * tile.step;
      };
      box.add(Vec3{at(0), at(1), at(2)});
    }
  }
  return box;
}

/// One run over a folder.
class Inspection {
 public:
  explicit Inspection(const fs::path& folder)
      : folder_(folder),
        manifest_(read_manifest(folder)),
        earth_(dem::earth_of(manifest_.frame)),
        boxes_(IndexWalk(folder, report_).run()) {}

  Verification run() {
    for (int level = 0; level < manifest_.levels; ++level) inspect(level);
    for (const auto& [file, box] : boxes_) {
      report_.add((folder_ / file).string(), "is in tileset.json, not in bake.json");
    }
    result_.problems = report_.take();
    return std::move(result_);
  }

 private:
  void inspect(int level) {
    std::vector<const Record*> records;
    for (const auto& record : manifest_.records) {
      if (record.key.level == level && !record.empty) records.push_back(&record);
    }
    std::ranges::sort(records, [](const Record* a, const Record* b) {
      return std::tie(a->key.y, a->key.x) < std::tie(b->key.y, b->key.x);
    });
    Seams seams(manifest_.lattice, level);
    std::uint64_t world_edges = 0;
    for (const auto* record : records) {
      world_edges += record->world_edges;
      try {
        inspect(*record, seams);
      } catch (const Error& error) {
        for (const auto& problem : error.problems) report_.add(problem.where, problem.what);
      }
    }
    seams.finish();
    sum_up(seams, level, world_edges);
  }

  void inspect(const Record& record, Seams& seams) {
    const auto file = store::tile_path(record.content);
    const std::string where = (folder_ / file).string();
    const auto bytes = store::get_tile(folder_, record.content);
    const double step = manifest_.lattice.step(record.key.level);
    const auto tile = glb::read(bytes, earth_ ? step / glb::finer : step, where);
    ++result_.tiles;
    result_.triangles += tile.surface.triangles.size();
    if (bytes.size() != record.bytes || tile.surface.triangles.size() != record.triangles ||
        tile.skirt.triangles.size() != record.skirt_triangles) {
      report_.add(where, "has another size than bake.json says");
    }
    const Box box = bounds(tile);
    if (box != record.box) report_.add(where, "has another box than bake.json says");
    const auto indexed = boxes_.find(file);
    if (indexed != boxes_.end()) {
      if (!indexed->second.contains(box)) report_.add(where, "its box in the tileset is too small");
      boxes_.erase(indexed);
    } else if (manifest_.complete) {
      report_.add(where, "is in bake.json, not in the tileset");
    }
    seams.add(record.key, earth_ ? glb::from_earth(tile, *earth_, step, where) : tile);
  }

  void sum_up(const Seams& seams, int level, std::uint64_t world_edges) {
    const auto where = fmt::format("level {}", level);
    for (int kind = 0; kind < Seams::kinds; ++kind) {
      const auto& fault = seams.faults()[static_cast<std::size_t>(kind)];
      if (fault.count == 0) continue;
      report_.add(where, fmt::format("{} {}, one at {}", fault.count,
                                     Seams::describe(static_cast<Seams::Kind>(kind)), fault.where));
    }
    if (manifest_.complete && seams.open_edges() != world_edges) {
      report_.add(where, fmt::format("{} edges have one face, {} should, at the world's edge",
                                     seams.open_edges(), world_edges));
    }
    result_.border_vertices += seams.border_vertices();
    result_.open_edges += seams.open_edges();
    result_.euler[level] = seams.euler();
  }

  const fs::path& folder_;
  Report report_;
  Manifest manifest_;
  std::optional<dem::Earth> earth_;
  std::map<fs::path, Box> boxes_;  // of the tileset, those not met yet
  Verification result_;
};

}  // namespace

Verification verify(const fs::path& folder) { return Inspection(folder).run(); }

}  // namespace hoodoo::tileset
