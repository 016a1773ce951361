#pragma once
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine/tree/ground.hpp"
#include "tiling/glb/tinygltf.hpp"

namespace hoodoo::glb {

/// JSON as tinygltf holds it.
tinygltf::Value to_value(const nlohmann::json& json);

/// Appends bytes to the model's buffer at a multiple of 8, as a buffer view. Returns its index.
int add_view(tinygltf::Model& model, std::span<const std::byte> bytes);

/// Adds the property table of the materials: one row each, the row being the feature id.
/// Source: EXT_structural_metadata and the Binary Table Format of the 3D Metadata Specification.
void add_materials(tinygltf::Model& model, const std::vector<tree::Material>& materials);

/// EXT_mesh_features of a primitive whose vertices carry `materials`.
tinygltf::Value features(std::span<const std::uint16_t> materials);

}  // namespace hoodoo::glb
