#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "tiling/glb/earth.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/glb/slabs.hpp"
#include "tiling/store/store.hpp"
#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/orphans.hpp"
#include "tiling/tileset/seams.hpp"

namespace hoodoo::tileset {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Problems are listed up to this many, and counted on.
constexpr std::size_t most_problems = 200;
/// Files that no index names are counted, and named up to this many.
constexpr std::size_t most_named = 5;

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
  /// Told of each file of a tile and the box in force for it. True: not met before.
  using Meet = std::function<bool(const fs::path&, const Box&)>;

  IndexWalk(const fs::path& folder, Report& report, Meet meet)
      : folder_(folder), report_(report), meet_(std::move(meet)) {}

  void run() {
    try {
      open("tileset.json", nullptr);
    } catch (const json::exception& error) {
      throw Error(Fault::bad_input, (folder_ / "tileset.json").string(),
                  std::string("is no tileset: ") + error.what());
    }
  }
  /// tileset.json and the external tilesets that it leads to.
  const std::set<fs::path>& files() const { return opened_; }

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
    if (tile.contains("content")) follow(tile.at("content"), path, here);
    if (tile.contains("contents")) {
      for (const auto& content : tile.at("contents")) follow(content, path, here);
    }
    if (!tile.contains("children")) return;
    for (const auto& child : tile.at("children")) visit(child, path, &here, false);
  }

  /// A content of `tile`, which may have a box of its own.
  void follow(const json& content, const fs::path& path, const Tile& tile) {
    const std::string where = (folder_ / path).string();
    const auto uri = text_of(content, "uri", where);
    const auto target = (path.parent_path() / uri).lexically_normal();
    if (target.is_absolute() || *target.begin() == "..") {
      return report_.add(where, "names a file outside: " + uri);
    }
    if (target.extension() == ".json") return open(target, &tile);
    const Box box = content.contains("boundingVolume") ? box_of(content, where) : tile.box;
    if (!tile.box.contains(box)) report_.add(where, "a content's box leaves its tile's");
    if (!meet_(target, box)) report_.add(where, "names a file twice: " + uri);
  }

  const fs::path& folder_;
  Report& report_;
  Meet meet_;
  std::set<fs::path> opened_;
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
        manifest_(folder),
        header_(manifest_.header()),
        earth_(dem::earth_of(header_.frame)) {}

  Verification run() {
    while (const auto entry = manifest_.next()) {
      if (entry->missing) continue;
      for (const auto& file : entry->record.files()) {
        files_.push_back({entry->key, entry->at, file.content.start()});
      }
    }
    std::ranges::sort(files_, {}, &Listed::content);
    IndexWalk walk(folder_, report_,
                   [this](const fs::path& file, const Box& box) { return meet(file, box); });
    walk.run();
    look_for_orphans(walk.files());
    std::ranges::sort(files_, {}, [](const Listed& file) {
      return std::tuple(file.key.level, file.key.y, file.key.x);
    });
    std::span<const Listed> rest(files_);
    for (int level = 0; level < header_.levels; ++level) {
      const auto end = std::ranges::find_if(
          rest, [level](const Listed& file) { return file.key.level > level; });
      const auto count = static_cast<std::size_t>(end - rest.begin());
      inspect(level, rest.first(count));
      rest = rest.subspan(count);
    }
    result_.problems = report_.take();
    return std::move(result_);
  }

 private:
  /// What is held of a tile's file.
  struct Listed {
    plan::Key key;          // of the tile
    std::uint64_t at;       // in bake.json
    std::uint64_t content;  // start of its digest
    bool met = false;       // in the tileset
  };

  /// Several tiles may have one content.
  bool meet(const fs::path& file, const Box& box) {
    const auto digest = store::digest_of(file);
    const auto start = digest ? digest->start() : 0;
    const std::span<Listed> same(std::ranges::lower_bound(files_, start, {}, &Listed::content),
                                 std::ranges::upper_bound(files_, start, {}, &Listed::content));
    bool fresh = same.empty();
    Box own;
    bool known = false;
    for (auto& listed : same) {
      for (const auto& slab : manifest_.record_at(listed.at).files()) {
        if (store::tile_path(slab.content) != file) continue;
        own = slab.box;
        known = true;
      }
      fresh = fresh || !listed.met;
      listed.met = true;
    }
    if (!known) {
      report_.add((folder_ / file).string(), "is in tileset.json, not in bake.json");
    } else if (!box.contains(own)) {
      report_.add((folder_ / file).string(), "its box in the tileset is too small");
    }
    return fresh;
  }

  void inspect(int level, std::span<const Listed> files) {
    Seams seams(header_.lattice, level);
    std::uint64_t world_edges = 0;
    while (!files.empty()) {
      const auto end = std::ranges::find_if(
          files, [&](const Listed& file) { return file.at != files.front().at; });
      const auto count = static_cast<std::size_t>(end - files.begin());
      const auto record = manifest_.record_at(files.front().at);
      world_edges += record.world_edges;
      try {
        inspect(record, files.first(count), seams);
      } catch (const Error& error) {
        for (const auto& problem : error.problems) report_.add(problem.where, problem.what);
      }
      files = files.subspan(count);
    }
    seams.finish();
    sum_up(seams, level, world_edges);
  }

  void look_for_orphans(const std::set<fs::path>& index) {
    const auto is_named = [&](const fs::path& file) {
      if (file == "bake.json" || index.contains(file)) return true;
      const auto digest = store::digest_of(file);
      return digest && file == store::tile_path(*digest) &&
             std::ranges::binary_search(files_, digest->start(), {}, &Listed::content);
    };
    const auto found = orphans(folder_, is_named, header_.complete);
    if (found.empty()) return;
    std::string what = fmt::format("{} files that no index names: ", found.size());
    for (std::size_t i = 0; i < std::min(found.size(), most_named); ++i) {
      what += (i > 0 ? ", " : "") + found[i].generic_string();
    }
    report_.add(folder_.string(), what + (found.size() > most_named ? ", ..." : ""));
  }

  /// The files of one tile.
  void inspect(const Record& record, std::span<const Listed> files, Seams& seams) {
    const double step = header_.lattice.step(record.key.level);
    std::vector<glb::Decoded> slabs;
    for (const auto& file : record.files()) {
      const auto listed = std::ranges::find(files, file.content.start(), &Listed::content);
      slabs.push_back(inspect(file, listed != files.end() && listed->met, step));
    }
    ++result_.tiles;
    const auto tile = glb::join(std::move(slabs));
    result_.triangles += tile.surface.triangles.size();
    const auto where = fmt::format("tile {}", record.key.text());
    seams.add(record.key, earth_ ? glb::from_earth(tile, *earth_, step, where) : tile);
  }

  /// One file of a tile by itself.
  glb::Decoded inspect(const Slab& slab, bool met, double step) {
    const auto file = store::tile_path(slab.content);
    const std::string where = (folder_ / file).string();
    const auto bytes = store::get_tile(folder_, slab.content);
    auto part = glb::read(bytes, earth_ ? step / glb::finer : step, where);
    if (bytes.size() != slab.bytes || part.surface.triangles.size() != slab.triangles ||
        part.skirt.triangles.size() != slab.skirt_triangles) {
      report_.add(where, "has another size than bake.json says");
    }
    const Box box = bounds(part);
    if (box != slab.box) report_.add(where, "has another box than bake.json says");
    if (!met && header_.complete) report_.add(where, "is in bake.json, not in the tileset");
    return part;
  }

  void sum_up(const Seams& seams, int level, std::uint64_t world_edges) {
    const auto where = fmt::format("level {}", level);
    for (int kind = 0; kind < Seams::kinds; ++kind) {
      const auto& fault = seams.faults()[static_cast<std::size_t>(kind)];
      if (fault.count == 0) continue;
      report_.add(where, fmt::format("{} {}, one at {}", fault.count,
                                     Seams::describe(static_cast<Seams::Kind>(kind)), fault.where));
    }
    if (header_.complete && seams.open_edges() != world_edges) {
      report_.add(where, fmt::format("{} edges have one face, {} should, at the world's edge",
                                     seams.open_edges(), world_edges));
    }
    result_.border_vertices += seams.border_vertices();
    result_.open_edges += seams.open_edges();
    result_.euler[level] = seams.euler();
  }

  const fs::path& folder_;
  Report report_;
  ManifestReader manifest_;
  const ManifestHeader& header_;
  std::optional<dem::Earth> earth_;
  std::vector<Listed> files_;
  Verification result_;
};

}  // namespace

Verification verify(const fs::path& folder) { return Inspection(folder).run(); }

}  // namespace hoodoo::tileset
