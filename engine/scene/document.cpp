#include "engine/scene/document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "engine/base/json.hpp"
#include "engine/dem/earth.hpp"
#include "engine/dem/raster.hpp"
#include "engine/scene/read_object.hpp"
#include "engine/scene/terrains.hpp"
#include "engine/scene/voxel_files.hpp"
#include "engine/tree/read_fields.hpp"
#include "engine/tree/stratum.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

constexpr std::size_t most_materials = 256;
constexpr std::size_t most_definitions = 100'000;
constexpr std::array<std::string_view, 6> other_keys = {"materials", "terrains",   "define",
                                                        "geology",   "operations", "bake"};

void read_materials(const json& scene, Document& into, Findings& findings) {
  auto& problems = findings.problems;
  const auto found = scene.find("materials");
  if (found != scene.end() && (!found->is_array() || found->empty())) {
    problems.push_back({"/materials", "must be an array of one at least"});
  } else if (found != scene.end() && found->size() > most_materials) {
    findings.limits.push_back({"/materials", fmt::format("has {} materials, the limit is {}",
                                                         found->size(), most_materials)});
  } else if (found != scene.end()) {
    std::map<std::string, std::string> names;
    for (std::size_t i = 0; i < found->size(); ++i) {
      const auto where = fmt::format("/materials/{}", i);
      MaterialSettings one;
      read_object((*found)[i], where, one, problems);
      const auto [other, fresh] = names.emplace(one.name, where);
      if (!fresh && !one.name.empty()) {
        problems.push_back({where + "/name", fmt::format("is that of {} too", other->second)});
      }
      into.materials.push_back(std::move(one));
    }
  }
  if (into.materials.empty()) {
    into.materials.push_back({"rock", {0x9a, 0x93, 0x88}, {0, 1}, 0.7, ""});
  }
}

void read_definitions(const json& scene, Document& into, Findings& findings) {
  const auto found = scene.find("define");
  if (found == scene.end()) return;
  if (!found->is_object()) {
    findings.problems.push_back({"/define", "must be an object"});
    return;
  }
  if (found->size() > most_definitions) {
    findings.limits.push_back({"/define", fmt::format("has {} definitions, the limit is {}",
                                                      found->size(), most_definitions)});
    return;
  }
  for (const auto& [name, tree] : found->items()) {
    into.context.definitions[name] = {&tree, "/define/" + pointer_token(name)};
  }
}

/// Adds the names that `from` uses, and those that they use in turn.
void add_used(const json& from, const tree::Context& context, std::set<std::string>& used) {
  std::vector<const json*> left = {&from};
  while (!left.empty()) {
    const json& one = *left.back();
    left.pop_back();
    if (const auto use = one.is_object() ? one.find("use") : one.end();
        one.is_object() && use != one.end() && use->is_string()) {
      const auto definition = context.definitions.find(use->get_ref<const std::string&>());
      if (definition != context.definitions.end() && used.insert(definition->first).second) {
        left.push_back(definition->second.json);
      }
    }
    if (one.is_structured()) {
      for (const auto& below : one) left.push_back(&below);
    }
  }
}

/// Definitions that nothing uses are checked too: as a terrain tree, or else as geology.
void check_unused(const json& scene, const Document& document, Findings& findings) {
  std::set<std::string> used;
  for (const auto* key : {"geology", "operations"}) {
    if (const auto found = scene.find(key); found != scene.end()) {
      add_used(*found, document.context, used);
    }
  }
  tree::Context scratch;
  scratch.definitions = document.context.definitions;
  scratch.read_voxels = document.context.read_voxels;
  scratch.check_balls = document.context.check_balls;
  for (const auto& [name, definition] : document.context.definitions) {
    if (used.count(name) != 0) continue;
    Problems terrain, geology;
    tree::parse_node(*definition.json, definition.where, tree::Family::terrain, scratch, terrain);
    if (!terrain.empty()) {
      tree::parse_node(*definition.json, definition.where, tree::Family::geology, scratch, geology);
    }
    if (scratch.stopped) return;
    if (terrain.empty() || geology.empty()) continue;
    findings.problems.insert(findings.problems.end(), terrain.begin(), terrain.end());
  }
}

void read_geology(const json& scene, Document& into, Findings& findings) {
  const auto found = scene.find("geology");
  if (found == scene.end() || found->is_null()) return;
  into.geology =
      tree::parse_node(*found, "/geology", tree::Family::geology, into.context, findings.problems);
}

void read_bake(const json& scene, Document& into, Findings& findings) {
  if (const auto found = scene.find("bake"); found != scene.end()) {
    read_object(*found, "/bake", into.bake, findings.problems);
  }
  if (into.bake.spacing) into.bake.spacing = dem::rounded_spacing(*into.bake.spacing);
}

/// Tiles on the Earth need a way there, from the heights, too.
void read_frame(Document& document, Findings& findings) {
  const auto& bake = document.bake;
  if (bake.frame == "local") {
    if (bake.vertical.empty()) return;
    findings.problems.push_back({"/bake/vertical", "is for \"frame\": \"ecef\" only"});
    return;
  }
  if (document.terrains.empty()) return;
  const auto& dem = document.terrains[0].info;
  document.vertical = bake.vertical.empty() ? dem.vertical : bake.vertical;
  if (document.vertical.empty()) {
    findings.problems.push_back(
        {"/bake/vertical",
         fmt::format("is missing: {} does not say what its heights count from, and a guess may be "
                     "100 m off; state \"ellipsoid\", or a vertical CRS such as \"EPSG:5773\"",
                     dem.path.string())});
    return;
  }
  try {
    auto frame = document.place.frame;
    frame.vertical = document.vertical;
    dem::Earth{frame};
  } catch (const Error& error) {
    for (const auto& problem : error.problems) {
      findings.problems.push_back({"/bake/vertical", problem.what});
    }
  }
}

/// Materials may name strata of the geology.
void check_strata(const Document& document, Findings& findings) {
  std::vector<std::string> names;
  if (document.geology) names = tree::strata_of(*document.geology);
  const std::vector<std::string_view> known(names.begin(), names.end());
  bool any_without = false;
  for (std::size_t i = 0; i < document.materials.size(); ++i) {
    const auto& name = document.materials[i].stratum;
    any_without = any_without || name.empty();
    if (name.empty() || std::find(known.begin(), known.end(), name) != known.end()) continue;
    const auto near = tree::nearest(name, known);
    findings.problems.push_back(
        {fmt::format("/materials/{}/stratum", i),
         near.empty()
             ? fmt::format("no stratum of the geology is named \"{}\"", name)
             : fmt::format("no stratum of the geology is named \"{}\": did you mean \"{}\"?", name,
                           near)});
  }
  if (!any_without) {
    findings.problems.push_back(
        {"/materials", "one at least must have no \"stratum\", for the rock that lies in none"});
  }
}

}  // namespace

Document read_document(const json& scene, const Sources& sources, Findings& findings) {
  Document document;
  if (!scene.is_object()) {
    findings.problems.push_back({"", "must be an object"});
    return document;
  }
  read_object(scene, "", document.header, findings.problems,
              {other_keys.begin(), other_keys.end()});
  read_materials(scene, document, findings);
  read_bake(scene, document, findings);
  read_terrains(scene, sources, document, findings);
  read_frame(document, findings);
  read_definitions(scene, document, findings);
  VoxelFiles grids(sources, findings);
  document.context.read_voxels = [&](const auto&... names) { return grids.read(names...); };
  BallFiles balls(sources, findings);
  document.context.check_balls = [&](const auto&... names) { return balls.check(names...); };
  const std::size_t before = findings.problems.size();
  read_geology(scene, document, findings);
  if (findings.problems.size() == before) check_strata(document, findings);
  document.operations =
      read_operations(scene, sources, document.materials, document.context, findings);
  check_unused(scene, document, findings);
  document.context.read_voxels = nullptr;  // they must not outlive what they read with
  document.context.check_balls = nullptr;
  document.balls = balls.take();
  findings.warnings.insert(findings.warnings.end(), document.context.warnings.begin(),
                           document.context.warnings.end());
  return document;
}

}  // namespace hoodoo::scene
