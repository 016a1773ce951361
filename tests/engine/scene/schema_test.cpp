#include <gmock/gmock.h>

#include <cstdlib>

#include "engine/base/file.hpp"
#include "engine/scene/brushes.hpp"
#include "engine/tree/nodes.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

/// Calls `visit` for every object below `at`, with a pointer to it.
template <class Visit>
void each_object(const json& at, const std::string& where, const Visit& visit) {
  if (at.is_object()) visit(at, where);
  if (!at.is_structured()) return;
  for (const auto& [key, below] : at.items()) each_object(below, where + "/" + key, visit);
}

TEST(SceneSchema, IsTheOneInTheRepository) {
  const std::filesystem::path file = HOODOO_SCHEMA_DIR "/scene.schema.json";
  const auto text = schema().dump(2) + "\n";
  if (std::getenv("HOODOO_BLESS") != nullptr) write_file(file, text);
  EXPECT_EQ(read_file(file, 1 << 24), text) << "run with HOODOO_BLESS=1 to accept the new schema";
}

TEST(SceneSchema, HasEveryReferenceItMakes) {
  const auto made = schema();
  each_object(made, "", [&](const json& one, const std::string& where) {
    const auto reference = one.find("$ref");
    if (reference == one.end() || !reference->is_string()) return;
    const auto target = reference->get<std::string>();
    ASSERT_EQ(target.substr(0, 8), "#/$defs/") << where;
    EXPECT_TRUE(made["$defs"].contains(target.substr(8))) << where << ": " << target;
  });
}

TEST(SceneSchema, ForbidsUnknownKeysEverywhere) {
  each_object(schema(), "", [&](const json& one, const std::string& where) {
    if (!one.contains("properties") || one["properties"].contains("$ref")) return;
    // Conditions, and choices by "type": what they lead to forbids them.
    if (where.ends_with("/if") || one.contains("allOf")) return;
    if (where.find("/properties/") != std::string::npos && !one.contains("type")) return;
    EXPECT_TRUE(one.contains("additionalProperties")) << where;
  });
}

TEST(SceneSchema, ListsEveryBrushAndEveryNode) {
  const auto definitions = schema()["$defs"];
  std::size_t brushes = 0, nodes = 0;
  for (const auto& [name, one] : definitions.items()) {
    if (name.rfind("brush.", 0) == 0) ++brushes;
    if (name.rfind("node.", 0) == 0) ++nodes;
  }
  EXPECT_EQ(brushes, std::variant_size_v<AnyBrush>);
  EXPECT_EQ(nodes, std::variant_size_v<tree::AnyNode>);
}

}  // namespace
}  // namespace hoodoo::scene
