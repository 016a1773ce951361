#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/tree/fields.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::generator {

/// JSON that holds trees, kept until the scene's definitions are known.
struct Stated {
  nlohmann::json json;  // null: none
  std::string where;    // JSON Pointer of it

  bool given() const { return !json.is_null(); }
};

/// Reads a node of a terrain's tree with all below it, `{"use": name}` expanded, and reports its
/// problems by itself.
using ReadTree =
    std::function<std::optional<tree::Node>(const nlohmann::json& json, const std::string& where)>;

/// Reports what a tree that is copied to many places may not have: points over the ground, and
/// balls in files.
void expect_movable(tree::Node& tree, const std::string& where, std::vector<Problem>& problems);

namespace form {
std::optional<Stated> read_stated(const nlohmann::json&, const std::string&, std::vector<Problem>&);
nlohmann::json tree_schema();
}  // namespace form

/// A node of a terrain's tree.
inline constexpr tree::Form<Stated> tree_form{&form::read_stated, &form::tree_schema};

}  // namespace hoodoo::generator
