#include "engine/generator/stated_tree.hpp"

namespace hoodoo::generator {

void expect_movable(tree::Node& tree, const std::string& where, std::vector<Problem>& problems) {
  bool symbolic = false, filed = false;
  tree::for_each_point(
      tree, [&](tree::Point& p) { symbolic = symbolic || p.form != tree::Point::Form::fixed; });
  tree::for_each_balls(tree, [&](tree::Balls& balls) { filed = filed || balls.in_file(); });
  std::function<void(const tree::Node&)> look = [&](const tree::Node& node) {
    std::visit(
        [&](const auto& n) {
          if constexpr (requires { n.balls.size(); }) filed = filed || !n.file.empty();
        },
        node.value);
    for (const auto& child : node.children) look(child);
  };
  look(tree);
  if (symbolic) {
    problems.push_back({where,
                        "has a point over the ground: it is copied to many places, so its "
                        "points must be [x, y, z] in m about its own origin"});
  }
  if (filed) {
    problems.push_back({where,
                        "has balls in a file: it is copied to many places, so its balls "
                        "must stand in the scene"});
  }
}

namespace form {

std::optional<Stated> read_stated(const nlohmann::json& json, const std::string& where,
                                  std::vector<Problem>& problems) {
  if (json.is_object()) return Stated{json, where};
  problems.push_back({where, "must be an object"});
  return std::nullopt;
}

nlohmann::json tree_schema() { return {{"$ref", "#/$defs/terrain_node"}}; }

}  // namespace form
}  // namespace hoodoo::generator
