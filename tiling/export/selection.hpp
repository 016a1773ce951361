#pragma once
#include <filesystem>
#include <optional>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/dem/earth.hpp"
#include "tiling/export/export.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::exporting {

/// The tiles of one level that are exported, read as they are asked for.
class Selection {
 public:
  /// Errors: not_found, io; bad_input, when `folder` holds no finished bake, or it does not have
  /// that level, or nothing in that region.
  Selection(const std::filesystem::path& folder, const Settings& settings);

  const tileset::Bake& bake() const { return bake_; }
  int level() const { return level_; }
  double spacing() const { return bake_.lattice.spacing(level_); }
  double step() const { return bake_.lattice.step(level_); }
  /// Those with a surface, by y, then by x.
  const std::vector<const tileset::Record*>& tiles() const { return tiles_; }
  Box box() const;  // of all of them [m]

  /// Errors: not_found, io; bad_input, when it is damaged.
  glb::Decoded read(const tileset::Record& record) const;

 private:
  Box box_in_scene(const tileset::Record& record) const;

  std::filesystem::path folder_;
  int level_;
  tileset::Bake bake_;
  std::optional<dem::Earth> earth_;
  std::vector<const tileset::Record*> tiles_;
};

}  // namespace hoodoo::exporting
