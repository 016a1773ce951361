#include "engine/scene/terrains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/dem/raster.hpp"
#include "engine/scene/read_object.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

constexpr std::size_t most_terrains = 64;
constexpr double most_cells = 68719476736.0;  // 2^36: 262 x 262 km at 1 m

/// Opens the DEM of one terrain; false when it has problems.
bool open_raster(Terrain& terrain, const std::string& where, const Sources& sources,
                 std::optional<double> spacing, std::optional<dem::Placement>& place,
                 Findings& findings) {
  const auto at = where + "/dem";
  const auto file = find_file(terrain.settings.dem, at, sources, findings);
  if (!file) return false;
  terrain.file = *file;
  try {
    const auto raster = dem::Raster::open(*file);
    terrain.info = raster->info();
    terrain.pixel = dem::place(*raster, std::nullopt).spacing;
    if (!place) place = dem::place(*raster, spacing);
  } catch (const Error& error) {
    refile(error, terrain, at, findings);
    return false;
  }
  return true;
}

/// Refuses a world with too many cells, by what the rasters claim and before any pixel is read.
void check_cells(const Document& document, Findings& findings) {
  const double spacing = document.place.spacing;
  for (const auto& terrain : document.terrains) {
    double width = static_cast<double>(terrain.info.width) * terrain.pixel;
    double depth = static_cast<double>(terrain.info.height) * terrain.pixel;
    if (const auto& extent = document.bake.extent) {
      width = std::min(width, extent->max.x - extent->min.x);
      depth = std::min(depth, extent->max.y - extent->min.y);
    }
    const auto before = findings.limits.size();
    check_size(width, depth, spacing, "/bake/spacing", findings);
    if (findings.limits.size() != before) return;
  }
}

}  // namespace

void refile(const Error& error, const Terrain& terrain, const std::string& where,
            Findings& findings) {
  const auto file = terrain.file.string();
  const bool other = std::none_of(
      error.problems.begin(), error.problems.end(),
      [&](const auto& problem) { return problem.where == file || problem.where.empty(); });
  if (error.fault == Fault::cancelled || error.fault == Fault::internal || other) throw error;
  Problems named;
  for (auto problem : error.problems) {
    for (auto at = problem.what.find(file); at != problem.what.npos; at = problem.what.find(file)) {
      problem.what.replace(at, file.size(), "it");
    }
    named.push_back({where, fmt::format("\"{}\": {}", terrain.settings.dem, problem.what)});
  }
  if (error.fault == Fault::io) throw Error(Fault::io, std::move(named));
  auto& list = error.fault == Fault::not_found ? findings.missing
               : error.fault == Fault::limit   ? findings.limits
                                               : findings.problems;
  list.insert(list.end(), named.begin(), named.end());
}

void check_size(double width, double depth, double spacing, const std::string& where,
                Findings& findings) {
  const double cells = (width / spacing) * (depth / spacing);
  if (cells <= most_cells) return;
  findings.limits.push_back(
      {where, fmt::format("{} m over {:.0f} x {:.0f} m makes {:.3g} cells, the limit is {:.0f}",
                          spacing, width, depth, cells, most_cells)});
}

void read_terrains(const json& scene, const Sources& sources, Document& into, Findings& findings) {
  auto& problems = findings.problems;
  const auto found = scene.find("terrains");
  if (found == scene.end()) {
    problems.push_back({"/terrains", "is missing"});
    return;
  }
  if (!found->is_array() || found->empty()) {
    problems.push_back({"/terrains", "must be an array of one at least"});
    return;
  }
  if (found->size() > most_terrains) {
    findings.limits.push_back({"/terrains", fmt::format("has {} terrains, the limit is {}",
                                                        found->size(), most_terrains)});
    return;
  }
  std::map<std::string, std::string> ids;
  std::optional<dem::Placement> place;
  for (std::size_t i = 0; i < found->size(); ++i) {
    const auto where = fmt::format("/terrains/{}", i);
    const auto before = problems.size();
    Terrain one;
    read_object((*found)[i], where, one.settings, problems);
    const auto& id = one.settings.id;
    const auto [other, fresh] = ids.emplace(id, where);
    if (!fresh && !id.empty()) {
      problems.push_back({where + "/id", fmt::format("is that of {} too", other->second)});
    }
    if (one.settings.dem.empty() && problems.size() != before) continue;
    if (open_raster(one, where, sources, into.bake.spacing, place, findings)) {
      into.terrains.push_back(std::move(one));
    }
  }
  if (!place) return;
  into.place = *place;
  check_cells(into, findings);
}

}  // namespace hoodoo::scene
