#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/picture.hpp"
#include "tiling/plan/plan.hpp"

/// tiling/compare: two finished bakes -> where and how far their surfaces differ.
namespace hoodoo::compare {

struct Settings {
  double tolerance = 0;      // [m]
  std::size_t pictures = 0;  // of how many of the worst changed tiles
};

/// A tile, or a region, that is not the same in both bakes.
struct Tile {
  enum class Change { changed, added, gone };  // a surface in both, in the second alone, the first

  plan::Key key;
  Change change = Change::changed;
  double largest = 0, mean = 0;  // two-sided distance of the surfaces [m]; of a change only
  double normal = 0;             // largest difference of normals [degrees]
  double material = 0;           // share of the area whose material changed
  bool beyond = true;            // it differs by more than the tolerance allows
};

/// A changed tile as it is in either bake, shaded by the distance to the other one.
struct View {
  plan::Key key;
  scene::Picture first, second;
};

struct Comparison {
  Settings settings;
  plan::Lattice first, second;
  bool by_region = false;          // the tiles of the two have no keys in common
  bool regions_of_second = false;  // keys are those of the second bake's leaves, not the first's
  std::uint64_t compared = 0;      // tiles or regions with a surface in either
  std::uint64_t read = 0;          // tile files
  std::vector<Tile> tiles;         // that differ, the worst first
  std::vector<View> views;         // of the first that changed

  std::size_t count(Tile::Change change) const;
  std::size_t beyond() const;
  bool same() const { return beyond() == 0; }
  /// The largest distance and the mean one of the changed tiles of a level [m].
  double largest(int level) const;
  double mean(int level) const;
};

/// Compares two finished bakes, tile by tile.
///
/// Where both have one lattice and origin, each tile is compared with the one of its key; tiles of
/// equal content hash are not read. Otherwise the leaves' surfaces are compared over the ground
/// that both cover, in regions, the leaves of the bake whose leaves are smaller; then only
/// distances are measured.
///
/// Distance is from samples of either surface, no farther apart than the spacing, to the nearest
/// point of the other one, in the tile or those around it: one that exceeds the side of a tile may
/// be too large. Normals are compared at vertices, with those interpolated at the nearest point.
/// The material at a sample has changed where the other surface has none of that name as near as
/// its nearest point or the tolerance.
///
/// A tile of level L differs when its distance exceeds 2^L times the tolerance, as its spacing is
/// 2^L times that of a leaf; when the material of more than 1 % of its area changed; or when only
/// one bake has it. Without a tolerance it differs by any byte.
///
/// About a dozen tiles of each bake are in memory at a time.
/// Errors: bad_input, not_found, io, naming the file: no bake, one that is not finished, frames
/// that do not agree, no common ground, tiles missing or damaged.
Comparison compare(const std::filesystem::path& first, const std::filesystem::path& second,
                   const Settings& settings = {});

/// {"same", "tolerance", "by": "tile" | "region", "spacings": [m, m],
///  "compared", "equal", "changed", "added", "gone", "beyond", "read": counts,
///  "largest", "mean": of the leaves [m],
///  "levels": [{"level", "changed", "largest", "mean"}],
///  "tiles": [{"key", "change": "changed" | "added" | "gone", "beyond", and of a change "largest",
///    "mean" [m], and by tile "normal" [degrees], "material" (share of the area)}]}, worst first.
nlohmann::json to_json(const Comparison& comparison);

/// What the comparison came to, in sentences; the last one counts.
std::vector<std::string> summary(const Comparison& comparison);

/// A page of HTML with a table and the views, without scripts or references to anything outside.
std::string page(const Comparison& comparison, std::string_view first, std::string_view second);

}  // namespace hoodoo::compare
