#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/base/file.hpp"
#include "engine/base/file_writer.hpp"
#include "engine/dem/earth.hpp"
#include "tiling/store/store.hpp"
#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/tree.hpp"

namespace hoodoo::tileset {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int levels_per_file = 4;
const fs::path part_folder = "subtrees";

/// The JSON of the index, external files first. What is held are the tiles of one file for each
/// four levels.
class Writer {
 public:
  Writer(const Index& index, const Tree& tree, const fs::path& folder)
      : index_(index), tree_(tree), folder_(folder) {}

  json tileset() {
    std::vector<json> roots;
    Box box;
    for (const auto* tile : tree_.roots()) {
      roots.push_back(inline_tile(*tile, levels_per_file, "").json);
      box.add(tree_.box(*tile));
    }
    json root;
    if (roots.size() == 1) {
      root = std::move(roots.front());
    } else {
      // A bake held to fewer levels has no tile over all of the world, or it is empty.
      root = {{"boundingVolume", volume(box)}, {"geometricError", diagonal(box)}};
      if (!roots.empty()) root["children"] = std::move(roots);
    }
    root["refine"] = "REPLACE";
    if (const auto earth = dem::earth_of(index_.frame)) root["transform"] = earth->transform();
    return document(std::move(root), box);
  }
  std::vector<fs::path>& files() { return files_; }

 private:
  /// A tile as the index has it, and its geometricError, which falls strictly from parent to
  /// child, whatever was measured.
  struct Shown {
    nlohmann::json json;
    double error = 0;
  };

  static double diagonal(const Box& box) { return box.empty() ? 0 : length(box.max - box.min); }

  /// Half sides of at least a step: a box without volume is none to some viewers.
  json volume(const Box& box) const {
    if (box.empty()) return {{"box", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}}};
    const Vec3 middle = (box.min + box.max) * 0.5, half = (box.max - box.min) * 0.5;
    const auto side = [&](double h) { return std::max(h, index_.lattice.step0); };
    return {{"box",
             {middle.x, middle.y, middle.z, side(half.x), 0.0, 0.0, 0.0, side(half.y), 0.0, 0.0,
              0.0, side(half.z)}}};
  }

  json head(const plan::Tile& tile, double error) const {
    return {{"boundingVolume", volume(tree_.box(tile))}, {"geometricError", error}};
  }

  /// One content, or one for each slab with the box it has to itself.
  void add_contents(json& tile, const Record& record, const std::string& to_top) const {
    const auto uri = [&](const Digest& content) {
      return to_top + store::tile_path(content).generic_string();
    };
    if (record.slabs.empty()) {
      tile["content"] = {{"uri", uri(record.content)}};
      return;
    }
    for (const auto& slab : record.slabs) {
      tile["contents"].push_back(
          {{"uri", uri(slab.content)}, {"boundingVolume", volume(slab.box)}});
    }
  }

  Shown inline_tile(const plan::Tile& tile, int levels, const std::string& to_top) {
    Shown shown;
    auto children = json::array();
    double least = 0;
    for (const auto* child : tree_.children(tile)) {
      auto below = levels > 1 || child->leaf ? inline_tile(*child, levels - 1, to_top)
                                             : external_tile(*child, to_top);
      least = std::max(least, below.error + index_.lattice.step(tile.level));
      children.push_back(std::move(below.json));
    }
    shown.error = children.empty() ? 0 : std::max(least, tile.error);
    shown.json = head(tile, shown.error);
    if (tile.has_content()) add_contents(shown.json, index_.read(tile), to_top);
    if (!children.empty()) shown.json["children"] = std::move(children);
    return shown;
  }

  /// A tile whose content is a file of its own: its root has the same box and error, and the glTF.
  Shown external_tile(const plan::Tile& tile, const std::string& to_top) {
    auto [root, error] = inline_tile(tile, levels_per_file, "../");
    root["refine"] = "REPLACE";
    const json file = document(std::move(root), tree_.box(tile));
    const std::string text = file.dump();
    // Named by content, so that an index of an earlier run stays whole until the last rename.
    const auto name = fmt::format("{}-{}-{}-{}.json", tile.level, tile.x, tile.y,
                                  sha256(text).hex().substr(0, 16));
    const fs::path path = part_folder / name;
    std::error_code failure;
    if (!fs::is_regular_file(folder_ / path, failure)) write_file(folder_ / path, text);
    files_.push_back(path);
    Shown shown{head(tile, error), error};
    shown.json["content"] = {{"uri", to_top.empty() ? path.generic_string() : name}};
    return shown;
  }

  static json document(json root, const Box& box) {
    const std::string version = sha256(root.dump()).hex().substr(0, 16);
    const double error = std::max(diagonal(box), root.at("geometricError").get<double>());
    return {{"asset", {{"version", "1.1"}, {"tilesetVersion", version}}},
            {"geometricError", error},
            {"root", std::move(root)}};
  }

  const Index& index_;
  const Tree& tree_;
  const fs::path& folder_;
  std::vector<fs::path> files_;
};

/// Removes external files that the index does not name. While tiles are missing, those of the last
/// minute stay: a viewer may still be following an earlier index.
void remove_stale(const fs::path& folder, const std::vector<fs::path>& files, bool complete) {
  const std::set<fs::path> keep(files.begin(), files.end());
  std::error_code error;
  std::vector<fs::path> stale;
  for (fs::directory_iterator at(folder / part_folder, error), end; !error && at != end;
       at.increment(error)) {
    const fs::path path = part_folder / at->path().filename();
    if (keep.contains(path) || is_leftover(path)) continue;
    const auto age = fs::file_time_type::clock::now() - at->last_write_time(error);
    if (complete || age > std::chrono::minutes(1)) stale.push_back(folder / path);
  }
  for (const auto& file : stale) fs::remove(file, error);
}

}  // namespace

Written write_index(Index& index, const fs::path& folder, const IndexSettings& settings) {
  const Tree tree(index, folder);
  Writer writer(index, tree, folder);
  const std::string text = writer.tileset().dump();
  Written written;
  written.files = std::move(writer.files());
  FileWriter manifest(folder / "bake.json"), tileset(folder / "tileset.json");
  write_manifest(index, settings, manifest, written);
  tileset.write(text);
  // Both are whole before either takes its place: a full disk leaves both as they were.
  manifest.sync();
  tileset.sync();
  manifest.commit();
  tileset.commit();
  remove_stale(folder, written.files, index.complete());
  written.files.emplace_back("bake.json");
  written.files.emplace_back("tileset.json");
  return written;
}

}  // namespace hoodoo::tileset
