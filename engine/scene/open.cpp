#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/random.hpp"
#include "engine/scene/document.hpp"
#include "engine/scene/points.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/terrains.hpp"
#include "engine/tree/pack.hpp"
#include "engine/tree/region.hpp"
#include "engine/tree/stratum.hpp"

namespace hoodoo::scene {
namespace {

/// Ingests every terrain. Errors of a DEM stand at its terrain.
void ingest(const Document& document, const OpenSettings& settings, Scene& scene) {
  const auto terrains = static_cast<double>(document.terrains.size());
  for (std::size_t i = 0; i < document.terrains.size(); ++i) {
    const auto& terrain = document.terrains[i];
    auto spend = settings.ingest;
    if (settings.ingest.progress) {
      spend.progress = [&, i](double part) {
        settings.ingest.progress((static_cast<double>(i) + part) / terrains);
      };
    }
    const auto where = fmt::format("/terrains/{}/dem", i);
    Findings findings;
    try {
      scene.pyramids.push_back(dem::Pyramid::ingest(terrain.file, scene.frame, terrain.pixel,
                                                    terrain.settings.nodata, settings.cache,
                                                    spend));
    } catch (const Error& error) {
      refile(error, terrain, where, findings);
    }
    findings.report();
    if (scene.pyramids.back()->extent().empty()) {
      throw Error(Fault::bad_input, where,
                  fmt::format("\"{}\" has no elevation but NoData", terrain.settings.dem));
    }
  }
}

/// Makes every point of the scene fixed. All that lie over a hole are reported at once.
void fix_points(const nlohmann::json& stated, Document& document, const Scene& scene) {
  const InputTerrain terrain(scene.ground.bodies, scene.pyramids);
  Findings findings;
  const VisitPoint fix = [&](tree::Point& point, const std::string& where) {
    if (const auto problem = terrain.fix(point)) findings.problems.push_back({where, *problem});
  };
  if (document.geology) {
    visit_points(*document.geology, stated["geology"], "/geology", document.context, fix);
  }
  for (auto& operation : document.operations) {
    if (auto* node = std::get_if<tree::Node>(&operation.shape)) {
      visit_points(*node, (*operation.json)["tree"], operation.where + "/tree", document.context,
                   fix);
    } else {
      visit_points(std::get<AnyBrush>(operation.shape), operation.where, fix);
    }
  }
  findings.report();
}

/// A stated seed and the scene's in one. The scene's seed 0 leaves it as it is stated.
std::uint32_t varied(std::uint32_t stated, std::uint64_t seed) {
  return seed == 0 ? stated : static_cast<std::uint32_t>(random_bits(seed, stated));
}

/// Varies every seed of a tree.
void vary(tree::Node& node, std::uint64_t seed) {
  const auto change = [&](auto& n) {
    if constexpr (requires { n.seed; }) n.seed = varied(n.seed, seed);
    if constexpr (requires { n.turbulence.seed; }) {
      n.turbulence.seed = varied(n.turbulence.seed, seed);
    }
  };
  std::visit(change, node.value);
  for (auto& child : node.children) vary(child, seed);
}

/// The tree of an operation whose points are fixed.
tree::Node tree_of(QueuedOperation& operation, std::uint64_t seed) {
  if (auto* node = std::get_if<tree::Node>(&operation.shape)) {
    vary(*node, seed);
    return std::move(*node);
  }
  const auto build = [&](auto& brush) {
    if constexpr (requires { brush.seed; }) brush.seed = varied(brush.seed, seed);
    brush.turbulence.seed = varied(brush.turbulence.seed, seed);
    return brush.build();
  };
  return std::visit(build, std::get<AnyBrush>(operation.shape));
}

void queue_steps(Document& document, Scene& scene) {
  for (auto& operation : document.operations) {
    auto tree = tree::pack(tree_of(operation, scene.seed));
    scene.ground.steps.push_back({operation.id, operation.where, operation.operation,
                                  std::move(tree), operation.region, operation.material});
  }
  scene.ground.geology = std::move(document.geology);
  if (scene.ground.geology) vary(*scene.ground.geology, scene.seed);
}

/// Binds materials to the strata they name, then packs the geology.
void bind_strata(tree::Ground& ground) {
  if (!ground.geology) return;
  for (std::size_t i = 0; i < ground.materials.size(); ++i) {
    const auto& name = ground.materials[i].stratum;
    if (name.empty()) continue;
    if (auto where = tree::where_prevails(*ground.geology, name)) {
      ground.seams.push_back({static_cast<int>(i), tree::pack(std::move(*where))});
    }
  }
  ground.geology = tree::pack(std::move(*ground.geology));
}

/// Everything the terrains cover, as far as "extent" allows. x and y.
Box plan_extent(const Document& document, const Scene& scene) {
  Box all;
  for (const auto& pyramid : scene.pyramids) all.add(pyramid->extent());
  if (!document.bake.extent) return all;
  const Box cut = intersection(all, *document.bake.extent);
  if (cut.min.x < cut.max.x && cut.min.y < cut.max.y) return cut;
  throw Error(Fault::bad_input, "/bake/extent",
              fmt::format("misses the terrains, which cover x [{:.2f}, {:.2f}] m, y [{:.2f}, "
                          "{:.2f}] m",
                          all.min.x, all.max.x, all.min.y, all.max.y));
}

/// The least and the greatest z [m] that can hold a surface: elevations, and what steps add.
void bound_heights(Scene& scene) {
  auto& extent = scene.extent;
  extent.min.z = Box::infinity;
  extent.max.z = -Box::infinity;
  const auto add = [&](double low, double high) {
    if (std::isfinite(low)) extent.min.z = std::min(extent.min.z, low);
    if (std::isfinite(high)) extent.max.z = std::max(extent.max.z, high);
  };
  for (std::size_t i = 0; i < scene.pyramids.size(); ++i) {
    const auto heights = scene.pyramids[i]->bounds(0, extent);
    const double offset = scene.ground.bodies[i].offset;
    if (heights) add(heights->low + offset, heights->high + offset);
  }
  for (const auto& step : scene.ground.steps) {
    Box reach = tree::support(step.tree).influence;
    if (step.region) reach = intersection(reach, step.region->influence());
    const bool near = !reach.empty() && reach.min.x <= extent.max.x &&
                      reach.max.x >= extent.min.x && reach.min.y <= extent.max.y &&
                      reach.max.y >= extent.min.y;
    if (near) {
      add(reach.min.z, reach.max.z);
    } else {
      scene.warnings.push_back(step.where + ": lies outside the world and changes nothing");
    }
  }
}

}  // namespace

Scene open(const nlohmann::json& stated, const Sources& sources, const OpenSettings& settings) {
  Findings findings;
  auto document = read_document(stated, sources, findings);
  findings.report();

  Scene scene;
  scene.name = document.header.name;
  scene.seed = document.header.seed;
  scene.frame = document.place.frame;
  scene.spacing = document.place.spacing;
  scene.bake = document.bake;
  for (const auto& warning : findings.warnings) {
    scene.warnings.push_back(warning.where + ": " + warning.what);
  }
  for (const auto& material : document.materials) {
    scene.ground.materials.push_back(material.material());
  }
  for (const auto& terrain : document.terrains) {
    scene.ground.bodies.push_back(terrain.settings.body(scene.spacing));
  }
  if (settings.checked) settings.checked();
  ingest(document, settings, scene);
  scene.frame.vertical = document.vertical;
  scene.extent = plan_extent(document, scene);
  check_size(scene.extent.max.x - scene.extent.min.x, scene.extent.max.y - scene.extent.min.y,
             scene.spacing, "/bake/spacing", findings);
  findings.report();
  fix_points(stated, document, scene);
  queue_steps(document, scene);
  bind_strata(scene.ground);
  bound_heights(scene);
  return scene;
}

std::vector<Problem> check(const nlohmann::json& stated, const Sources& sources,
                           std::vector<Problem>* warnings) {
  Findings findings;
  read_document(stated, sources, findings);
  if (warnings != nullptr) *warnings = findings.warnings;
  return findings.all();
}

}  // namespace hoodoo::scene
