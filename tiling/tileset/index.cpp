#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/base/file.hpp"
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

/// The JSON of the index, external files first.
class Writer {
 public:
  Writer(const Bake& bake, const Tree& tree, const std::map<plan::Key, double>& given,
         const fs::path& folder)
      : bake_(bake), tree_(tree), folder_(folder) {
    raise(given);
  }

  json tileset() {
    std::vector<json> roots;
    for (const auto& key : tree_.roots) roots.push_back(inline_tile(key, levels_per_file, ""));
    json root;
    Box box;
    for (const auto& key : tree_.roots) box.add(tree_.nodes.at(key).box);
    if (roots.size() == 1) {
      root = std::move(roots.front());
    } else {
      // A bake held to fewer levels has no tile over all of the world, or it is empty.
      root = {{"boundingVolume", volume(box)}, {"geometricError", diagonal(box)}};
      if (!roots.empty()) root["children"] = roots;
    }
    root["refine"] = "REPLACE";
    if (const auto earth = dem::earth_of(bake_.frame)) root["transform"] = earth->transform();
    return document(std::move(root), box);
  }
  const std::vector<fs::path>& files() const { return files_; }

 private:
  /// Errors that fall strictly from parent to child, whatever is given.
  void raise(const std::map<plan::Key, double>& given) {
    for (const auto& [key, node] : tree_.nodes) {
      double least = 0;
      for (const auto& child : node.children) {
        least = std::max(least, errors_.at(child) + bake_.lattice.step(key.level));
      }
      const auto at = given.find(key);
      errors_[key] =
          node.children.empty() ? 0 : std::max(least, at == given.end() ? 0 : at->second);
    }
  }

  static double diagonal(const Box& box) { return box.empty() ? 0 : length(box.max - box.min); }

  /// Half sides of at least a step: a box without volume is none to some viewers.
  json volume(const Box& box) const {
    if (box.empty()) return {{"box", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}}};
    const Vec3 middle = (box.min + box.max) * 0.5, half = (box.max - box.min) * 0.5;
    const auto side = [&](double h) { return std::max(h, bake_.lattice.step0); };
    return {{"box",
             {middle.x, middle.y, middle.z, side(half.x), 0.0, 0.0, 0.0, side(half.y), 0.0, 0.0,
              0.0, side(half.z)}}};
  }

  json head(const plan::Key& key) const {
    return {{"boundingVolume", volume(tree_.nodes.at(key).box)},
            {"geometricError", errors_.at(key)}};
  }

  json inline_tile(const plan::Key& key, int levels, const std::string& to_top) {
    const auto& node = tree_.nodes.at(key);
    json tile = head(key);
    if (node.has_content()) {
      tile["content"] = {{"uri", to_top + store::tile_path(node.record->content).generic_string()}};
    }
    if (node.children.empty()) return tile;
    auto& children = tile["children"] = json::array();
    for (const auto& child : node.children) {
      const bool leaf = tree_.nodes.at(child).children.empty();
      children.push_back(levels > 1 || leaf ? inline_tile(child, levels - 1, to_top)
                                            : external_tile(child, to_top));
    }
    return tile;
  }

  /// A tile whose content is a file of its own: its root has the same box and error, and the glTF.
  json external_tile(const plan::Key& key, const std::string& to_top) {
    json root = inline_tile(key, levels_per_file, "../");
    root["refine"] = "REPLACE";
    const json file = document(std::move(root), tree_.nodes.at(key).box);
    const std::string text = file.dump();
    // Named by content, so that an index of an earlier run stays whole until the last rename.
    const auto name =
        fmt::format("{}-{}-{}-{}.json", key.level, key.x, key.y, sha256(text).hex().substr(0, 16));
    const fs::path path = part_folder / name;
    std::error_code error;
    if (!fs::is_regular_file(folder_ / path, error)) write_file(folder_ / path, text);
    files_.push_back(path);
    json tile = head(key);
    tile["content"] = {{"uri", to_top.empty() ? path.generic_string() : name}};
    return tile;
  }

  static json document(json root, const Box& box) {
    const std::string version = sha256(root.dump()).hex().substr(0, 16);
    const double error = std::max(diagonal(box), root.at("geometricError").get<double>());
    return {{"asset", {{"version", "1.1"}, {"tilesetVersion", version}}},
            {"geometricError", error},
            {"root", std::move(root)}};
  }

  const Bake& bake_;
  const Tree& tree_;
  const fs::path& folder_;
  std::map<plan::Key, double> errors_;
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

std::vector<fs::path> write_index(const Bake& bake, const std::map<plan::Key, double>& errors,
                                  const fs::path& folder) {
  const Tree tree = make_tree(bake);
  Writer writer(bake, tree, errors, folder);
  const std::string text = writer.tileset().dump();
  auto files = writer.files();
  write_file(folder / "bake.json", manifest_text(bake, errors));
  write_file(folder / "tileset.json", text);
  remove_stale(folder, files, bake.complete());
  files.emplace_back("bake.json");
  files.emplace_back("tileset.json");
  for (const auto& record : bake.records) {
    if (!record.empty) files.push_back(store::tile_path(record.content));
  }
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

}  // namespace hoodoo::tileset
