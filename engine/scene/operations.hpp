#pragma once
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine/scene/copies.hpp"
#include "engine/scene/files.hpp"
#include "engine/scene/settings.hpp"
#include "engine/scene/tools.hpp"
#include "engine/tree/ground.hpp"
#include "engine/tree/parse.hpp"

namespace hoodoo::scene {

/// What every operation may carry beside its tree, brush or generator.
struct OperationSettings {
  std::string id;
  std::string material;

  static constexpr auto fields() {
    using T = OperationSettings;
    return std::tuple{
        tree::Text<T>{"id", &T::id, "", "Names it, uniquely."},
        tree::Text<T>{"material", &T::material, "",
                      "Name of the rock that it leaves; by default the resistance decides."}};
  }
};

/// {"op": ..., "tree": ...} without its tree.
struct TreeOperation {
  static constexpr std::array<std::string_view, 5> names = {"blend", "carve", "union", "difference",
                                                            "intersect"};
  tree::Operation op = tree::Operation::unite;

  static constexpr auto fields() {
    using T = TreeOperation;
    return std::tuple{tree::Choice<T, tree::Operation>{
        "op", &T::op, names, tree::required,
        "How the tree joins what is there: sum, sum with opposite sign, max, min with the "
        "opposite, min."}};
  }
};

/// One operation of the queue as the scene states it, points still symbolic.
struct QueuedOperation {
  const nlohmann::json* json;  // of the whole operation
  std::string where;           // JSON Pointer of it
  std::string id;
  std::shared_ptr<const tree::Region> region;  // null: everywhere
  int material = -1;
  tree::Operation operation = tree::Operation::unite;
  std::variant<tree::Node, AnyTool> shape;
  Copies copies{};
};

/// tree::parse_node with its problems among `findings`; a broken limit is one.
std::optional<tree::Node> read_tree(const nlohmann::json& json, const std::string& where,
                                    tree::Family family, tree::Context& context,
                                    Findings& findings);

/// Reads the "operations" of a scene. Those with problems are left out.
std::vector<QueuedOperation> read_operations(const nlohmann::json& scene, const Sources& sources,
                                             const std::vector<MaterialSettings>& materials,
                                             tree::Context& context, Findings& findings);

}  // namespace hoodoo::scene
