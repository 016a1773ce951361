#pragma once
#include <nlohmann/json_fwd.hpp>

#include "engine/scene/document.hpp"

namespace hoodoo::scene {

/// Reads "terrains": opens every DEM as far as its tags, and places the scene by the first.
/// `into.bake` has been read.
void read_terrains(const nlohmann::json& scene, const Sources& sources, Document& into,
                   Findings& findings);

/// A limit at `where`, when a world of `width` x `depth` [m] has more cells in plan at `spacing`
/// [m] than can be baked.
void check_size(double width, double depth, double spacing, const std::string& where,
                Findings& findings);

/// Puts an error of a terrain's file, whose "dem" stands at `where`, among `findings`, under the
/// name that the scene gives the file. Errors that are not the file's are thrown again.
void refile(const Error& error, const Terrain& terrain, const std::string& where,
            Findings& findings);

}  // namespace hoodoo::scene
