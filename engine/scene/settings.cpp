#include "engine/scene/settings.hpp"

#include <fmt/format.h>

#include "engine/scene/scene.hpp"

namespace hoodoo::scene {

void BakeSettings::check(const std::string& where, std::vector<Problem>& problems) const {
  if (tile_cells % 16 == 0) return;
  problems.push_back(
      {where + "/tile_cells", fmt::format("must be a multiple of 16, got {}", tile_cells)});
}

void MaterialSettings::check(const std::string& where, std::vector<Problem>& problems) const {
  if (name.empty()) problems.push_back({where + "/name", "must not be empty"});
}

}  // namespace hoodoo::scene
