#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "engine/tree/node.hpp"

namespace hoodoo::scene {

/// A square picture, rows from the top, 8-bit sRGB.
struct Picture {
  int size = 0;  // [pixels]
  std::vector<std::uint8_t> rgb;
};

/// How a tree looks from the south-west and above, in parallel projection: of a terrain tree its
/// surface F = 1/2, cut open by the faces of a cube; of a geology tree rho on three faces of that
/// cube, dark to light. The cube stands around the tree's influence, or around the origin where
/// that has no end. Points of the tree are fixed.
Picture draw(const tree::Node& tree, tree::Family family, int size);

/// Reads one tree as it stands in a scene ("tree", "geology") and without "use". Files that it
/// names lie below `folder`. Errors: bad_input, not_found, limit.
tree::Node read_tree(const nlohmann::json& json, tree::Family family,
                     const std::filesystem::path& folder = {});

/// The bytes of a PNG.
std::vector<unsigned char> png(const Picture& picture);

/// Writes a PNG. Errors: io.
void write_png(const Picture& picture, const std::filesystem::path& file);

}  // namespace hoodoo::scene
