#include "engine/tree/ground.hpp"

#include <nlohmann/json.hpp>

#include "engine/tree/composite.hpp"
#include "engine/tree/parse.hpp"
#include "engine/tree/region.hpp"

namespace hoodoo::tree {
namespace {

constexpr std::array names{"blend", "carve", "union", "difference", "intersect", "replace"};

/// Where the step can change F.
Box influence(const Step& step) {
  // Outside its tree an intersection leaves nothing.
  Box box = acts_by_zero(step.operation) ? Box::everywhere() : support(step.tree).influence;
  if (step.region) box = intersection(box, step.region->influence());
  return box;
}

nlohmann::json to_json(const HeightBody& body) {
  return {{"id", body.id},
          {"falloff", body.falloff},
          {"slope_corrected", body.slope_corrected},
          {"inverted", body.inverted},
          {"offset", body.offset},
          {"domain", body.domain}};
}

nlohmann::json to_json(const Step& step) {
  return {{"id", step.id},
          {"op", names[static_cast<std::size_t>(step.operation)]},
          {"tree", to_json(step.tree)},
          {"region", step.region ? to_json(*step.region) : nlohmann::json()},
          {"material", step.material}};
}

nlohmann::json to_json(const Material& material) {
  return {{"name", material.name},
          {"color", material.color},
          {"resistance", {material.low, material.high}},
          {"friction", material.friction}};
}

nlohmann::json to_json(const Seam& seam) {
  return {{"material", seam.material}, {"tree", to_json(seam.tree)}};
}

}  // namespace

Ground prune(const Ground& ground, const Box& reach, double thinnest) {
  Ground pruned;
  pruned.bodies = ground.bodies;
  pruned.materials = ground.materials;
  for (const Step& step : ground.steps) {
    if (step.region && !step.region->influence().overlaps(reach)) continue;
    Step kept = step;
    kept.tree = prune(step.tree, reach, thinnest);
    if (is_nothing(kept.tree) && !acts_by_zero(step.operation)) continue;
    pruned.steps.push_back(std::move(kept));
  }
  // Thin layers of rock are seen on a coarse surface, too.
  if (ground.geology) pruned.geology = prune(*ground.geology, reach, 0);
  for (const Seam& seam : ground.seams) {
    Node tree = prune(seam.tree, reach, 0);
    if (!is_nothing(tree)) pruned.seams.push_back({seam.material, std::move(tree)});
  }
  return pruned;
}

Ground without_balls(Ground ground, std::vector<Digest>& lists) {
  const auto empty = [&](Balls& balls) {
    lists.push_back(balls.digest());
    balls = Balls();
  };
  for (Step& step : ground.steps) for_each_balls(step.tree, empty);
  if (ground.geology) for_each_balls(*ground.geology, empty);
  for (Seam& seam : ground.seams) for_each_balls(seam.tree, empty);
  return ground;
}

Box influence(const Ground& ground) {
  Box all;
  for (const Step& step : ground.steps) all.add(influence(step));
  return all;
}

nlohmann::json to_json(const Ground& ground) {
  nlohmann::json json{{"bodies", nlohmann::json::array()},
                      {"steps", nlohmann::json::array()},
                      {"materials", nlohmann::json::array()},
                      {"geology", ground.geology ? to_json(*ground.geology) : nlohmann::json()}};
  for (const HeightBody& body : ground.bodies) json["bodies"].push_back(to_json(body));
  for (const Step& step : ground.steps) json["steps"].push_back(to_json(step));
  for (const Seam& seam : ground.seams) json["seams"].push_back(to_json(seam));
  for (const Material& material : ground.materials) {
    json["materials"].push_back(to_json(material));
  }
  return json;
}

}  // namespace hoodoo::tree
