#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/dem/dem.hpp"
#include "engine/scene/ball_files.hpp"
#include "engine/scene/files.hpp"
#include "engine/scene/operations.hpp"
#include "engine/scene/settings.hpp"
#include "engine/tree/parse.hpp"

namespace hoodoo::scene {

/// One of "terrains" and the file it names.
struct Terrain {
  TerrainSettings settings;
  std::filesystem::path file;
  dem::RasterInfo info;
  double pixel = 1;  // ground size of its pixels [m]
};

/// A scene as it is written, checked as far as that goes without reading elevations.
/// Points into the JSON it was read from.
struct Document {
  Header header;
  std::vector<MaterialSettings> materials;  // never empty
  std::vector<Terrain> terrains;            // those without problems
  std::optional<tree::Node> geology;
  std::vector<QueuedOperation> operations;  // those without problems
  BakeSettings bake;
  dem::Placement place;  // by the first terrain
  std::string vertical;  // what heights count from, where the tiles lie on the Earth; "" else
  tree::Context context;
  std::map<std::string, BallFacts> balls;  // by the names of their files
};

/// Reads a scene. The document is fit for use only if `findings` stay empty but for warnings.
Document read_document(const nlohmann::json& scene, const Sources& sources, Findings& findings);

}  // namespace hoodoo::scene
