#pragma once
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/dem/dem.hpp"
#include "engine/scene/operations.hpp"
#include "engine/tree/ground.hpp"
#include "engine/tree/parse.hpp"

/// Turns the points that a scene states over the ground into fixed ones.
namespace hoodoo::scene {

/// Elevations of the input terrains: those of the first that has data at a place.
class InputTerrain {
 public:
  /// One pyramid per body.
  InputTerrain(const std::vector<tree::HeightBody>& bodies,
               const std::vector<std::shared_ptr<const dem::Pyramid>>& pyramids)
      : bodies_(bodies), pyramids_(pyramids) {}

  /// Makes `point` fixed; its problem when that cannot be.
  std::optional<std::string> fix(tree::Point& point) const;

 private:
  std::optional<double> height(double x, double y) const;

  const std::vector<tree::HeightBody>& bodies_;
  const std::vector<std::shared_ptr<const dem::Pyramid>>& pyramids_;
};

/// A point and the JSON Pointer of it.
using VisitPoint = std::function<void(tree::Point&, const std::string& where)>;

/// Visits every point of a tree that was parsed from `json`, which stands at `where`.
void visit_points(tree::Node& tree, const nlohmann::json& json, const std::string& where,
                  const tree::Context& context, const VisitPoint& visit);
/// Visits every point of a brush or generator, which stands at `where`.
void visit_points(AnyTool& tool, const std::string& where, const VisitPoint& visit);

}  // namespace hoodoo::scene
