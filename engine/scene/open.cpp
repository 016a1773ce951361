#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/random.hpp"
#include "engine/generator/growth.hpp"
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
    spend.memory /= document.terrains.size();  // pyramids keep chunks in memory side by side
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
      // What the document says of it, the frame too, comes from before the ingest.
      dem::expect_unchanged(terrain.file, terrain.info.state);
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

/// Reads the balls of every tree that names a file of them.
void load_balls(Document& document, const OpenSettings& settings, Scene& scene) {
  const auto memory = std::max(settings.ball_memory, settings.ingest.memory / 4);
  BallLoader loader(std::move(document.balls), settings.cache, settings.ball_memory, memory);
  if (document.geology) loader.load(*document.geology);
  for (auto& operation : document.operations) {
    if (auto* node = std::get_if<tree::Node>(&operation.shape)) loader.load(*node);
  }
  scene.ball_files = loader.kept();
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
      visit_points(std::get<AnyTool>(operation.shape), operation.where, fix);
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

/// Queues one operation after the other; each generator sees those before it.
class Queue {
 public:
  Queue(const OpenSettings& settings, Scene& scene)
      : settings_(settings),
        scene_(scene),
        terrain_(scene.ground.bodies, scene.pyramids),
        site_(scene.ground, scene.pyramids, scene.spacing, scene.extent,
              {settings.ingest.threads, settings.ingest.memory, settings.ingest.stop}) {}

  void add(QueuedOperation& operation) {
    if (auto* node = std::get_if<tree::Node>(&operation.shape)) {
      vary(*node, scene_.seed);
      add(operation, [&](std::uint64_t seed) {
        tree::Node copy = *node;
        vary(copy, seed);
        return copy;
      });
      return;
    }
    std::visit(
        [&]<class T>(T& tool) {
          if constexpr (Brush<T>) {
            vary_brush(tool, scene_.seed);
            add(operation, [&](std::uint64_t seed) {
              T copy = tool;
              vary_brush(copy, seed);
              return copy.build();
            });
          } else {
            grow(operation, tool);
          }
        },
        std::get<AnyTool>(operation.shape));
  }

 private:
  template <Brush T>
  static void vary_brush(T& brush, std::uint64_t seed) {
    if constexpr (requires { brush.seed; }) brush.seed = varied(brush.seed, seed);
    brush.turbulence.seed = varied(brush.turbulence.seed, seed);
  }

  void add(const QueuedOperation& operation, const Rebuild& build) {
    auto tree = with_copies(build, operation.copies, seed_of(operation.id, 0), terrain_,
                            operation.where, scene_.warnings);
    scene_.ground.steps.push_back({operation.id, operation.where, operation.operation,
                                   tree::pack(std::move(tree)), operation.region,
                                   operation.material});
  }

  template <class T>
  void grow(const QueuedOperation& operation, const T& tool) {
    auto& record = scene_.grown.emplace_back();
    record.type = T::type;
    record.id = operation.id;
    record.where = operation.where;
    record.first_step = scene_.ground.steps.size();
    std::uint32_t own = 0;
    if constexpr (requires { tool.seed; }) own = tool.seed;
    generator::Growth growth{site_, record, seed_of(operation.id, own), operation.region,
                             operation.material};
    try {
      tool.grow(growth);
    } catch (const Error& error) {
      if (error.fault != Fault::limit && error.fault != Fault::bad_input) throw;
      std::vector<Problem> problems = error.problems;
      for (auto& problem : problems) problem.where = operation.where + problem.where;
      throw Error(error.fault, std::move(problems));
    }
    if (!settings_.keep_marks) {
      record.marks.clear();
      record.edges.clear();
    }
    for (auto& step : std::span(scene_.ground.steps).subspan(record.first_step)) {
      step.tree = tree::pack_unions(std::move(step.tree));
      spill(step.tree);
    }
  }

  /// Puts long lists of balls on the disk, from where tiles read those in their reach.
  void spill(tree::Node& tree) {
    std::visit(
        [&](auto& node) {
          if constexpr (requires { node.balls.in_file(); }) {
            if (node.balls.in_file() || node.balls.size() <= most_balls_in(settings_.ball_memory)) {
              return;
            }
            node.balls = in_file(node.balls, settings_.cache, settings_.ingest.memory / 4,
                                 scene_.ball_files);
          }
        },
        tree.value);
  }

  std::uint64_t seed_of(const std::string& id, std::uint32_t own) const {
    std::uint64_t seed = random_bits(scene_.seed, own);
    for (const char c : id) seed = random_bits(seed, static_cast<unsigned char>(c));
    return seed;
  }

  const OpenSettings& settings_;
  Scene& scene_;
  InputTerrain terrain_;
  generator::Site site_;
};

/// The geology: materials bound to the strata they name, then packed.
void take_geology(Document& document, Scene& scene) {
  auto& ground = scene.ground;
  ground.geology = std::move(document.geology);
  if (!ground.geology) return;
  vary(*ground.geology, scene.seed);
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

/// Makes the extent hold these heights [m], as far as they are finite.
void add_heights(double low, double high, Box& extent) {
  if (std::isfinite(low)) extent.min.z = std::min(extent.min.z, low);
  if (std::isfinite(high)) extent.max.z = std::max(extent.max.z, high);
}

/// The least and the greatest z [m] that can hold a surface: of the elevations, and the floor.
void bound_elevations(Scene& scene) {
  auto& extent = scene.extent;
  extent.min.z = Box::infinity;
  extent.max.z = -Box::infinity;
  for (std::size_t i = 0; i < scene.pyramids.size(); ++i) {
    const auto heights = scene.pyramids[i]->bounds(0, extent);
    const double offset = scene.ground.bodies[i].offset;
    if (heights) add_heights(heights->low + offset, heights->high + offset, extent);
  }
  if (scene.bake.base && extent.min.z <= extent.max.z) {
    scene.floor = extent.min.z - *scene.bake.base;
    add_heights(*scene.floor, *scene.floor, extent);
  }
}

/// The same, and of what steps add.
void bound_steps(Scene& scene) {
  auto& extent = scene.extent;
  for (const auto& step : scene.ground.steps) {
    Box reach = tree::support(step.tree).influence;
    if (step.region) reach = intersection(reach, step.region->influence());
    const bool near = !reach.empty() && reach.min.x <= extent.max.x &&
                      reach.max.x >= extent.min.x && reach.min.y <= extent.max.y &&
                      reach.max.y >= extent.min.y;
    if (near) {
      add_heights(reach.min.z, reach.max.z, extent);
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
  if (settings.ingested) settings.ingested();
  scene.frame.vertical = document.vertical;
  scene.extent = plan_extent(document, scene);
  check_size(scene.extent.max.x - scene.extent.min.x, scene.extent.max.y - scene.extent.min.y,
             scene.spacing, "/bake/spacing", findings);
  findings.report();
  load_balls(document, settings, scene);
  fix_points(stated, document, scene);
  take_geology(document, scene);
  bound_elevations(scene);
  Queue queue(settings, scene);
  for (auto& operation : document.operations) queue.add(operation);
  bound_steps(scene);
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
