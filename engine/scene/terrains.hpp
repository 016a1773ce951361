#pragma once
#include <nlohmann/json_fwd.hpp>

#include "engine/scene/document.hpp"

namespace hoodoo::scene {

/// Reads "terrains": opens every DEM as far as its tags, and places the scene by the first.
/// `into.bake` has been read.
void read_terrains(const nlohmann::json& scene, const Sources& sources, Document& into,
                   Findings& findings);

/// Puts an error of a file that the scene calls `name` at `where`, without the file's own path.
void refile(const Error& error, const std::string& name, const std::string& where,
            Findings& findings);

}  // namespace hoodoo::scene
