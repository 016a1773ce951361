// The reference of the nodes says what the types say, and every type has an example that shows it.
// HOODOO_BLESS=1 writes the page and the pictures anew.
#include "engine/scene/reference.hpp"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/scene/picture.hpp"

using namespace hoodoo;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

const fs::path schema_folder = HOODOO_SCHEMA_DIR;
bool blessed() { return std::getenv("HOODOO_BLESS") != nullptr; }

/// A tree has a node of `type` somewhere.
bool has_type(const json& tree, const std::string& type) {
  if (tree.is_object() && tree.value("type", "") == type) return true;
  return tree.is_structured() && std::any_of(tree.begin(), tree.end(), [&](const json& below) {
           return has_type(below, type);
         });
}

/// Geology where a tree is none of terrain.
tree::Family family_of(const json& tree) {
  try {
    scene::read_tree(tree, tree::Family::terrain, schema_folder / "nodes");
    return tree::Family::terrain;
  } catch (const Error&) {
    return tree::Family::geology;
  }
}

std::vector<std::uint8_t> pixels_of(const fs::path& file) {
  const auto input = OIIO::ImageInput::open(file.string());
  if (!input) return {};
  const auto& spec = input->spec();
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(spec.width * spec.height * 3));
  if (spec.nchannels != 3) return {};
  return input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, pixels.data())
             ? pixels
             : std::vector<std::uint8_t>();
}

}  // namespace

TEST(NodeReference, IsThePageInTheRepository) {
  const auto text = scene::node_reference();
  const auto page = schema_folder / "NODES.md";
  if (blessed()) write_file(page, text);
  EXPECT_EQ(read_file(page, 1U << 24), text) << "run with HOODOO_BLESS=1 to accept the new page";
}

TEST(ToolReference, IsThePageInTheRepository) {
  const auto text = scene::tool_reference();
  const auto page = schema_folder / "TOOLS.md";
  if (blessed()) write_file(page, text);
  EXPECT_EQ(read_file(page, 1U << 24), text) << "run with HOODOO_BLESS=1 to accept the new page";
}

TEST(NodeReference, HasAnExampleOfEveryTypeAndItsPicture) {
  const auto names = scene::node_names();
  EXPECT_GT(names.size(), 40U);
  for (const auto& [type, families] : names) {
    SCOPED_TRACE(type);
    const auto example = schema_folder / "nodes" / (type + ".json");
    ASSERT_TRUE(fs::exists(example));
    const auto tree = json::parse(read_file(example, 1U << 20));
    EXPECT_TRUE(has_type(tree, type));
    const auto family = family_of(tree);
    const auto read = scene::read_tree(tree, family, schema_folder / "nodes");
    const auto picture = scene::draw(read, family, 200);
    const auto file = schema_folder / "nodes" / (type + ".png");
    if (blessed()) scene::write_png(picture, file);
    EXPECT_EQ(pixels_of(file), picture.rgb) << "run with HOODOO_BLESS=1 to accept the new picture";
  }
}
