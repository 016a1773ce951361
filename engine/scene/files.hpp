#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/scene/scene.hpp"

namespace hoodoo::scene {

/// What is wrong with a scene, by the fault it makes.
struct Findings {
  std::vector<Problem> problems;  // bad_input
  std::vector<Problem> missing;   // not_found
  std::vector<Problem> limits;    // limit
  std::vector<Problem> warnings;  // no fault

  bool any() const { return !problems.empty() || !missing.empty() || !limits.empty(); }
  std::vector<Problem> all() const;
  /// Throws what was found, if anything: bad_input unless all of it is of another kind.
  void report() const;
};

/// Finds the regular file that a scene calls `name` at `where`: below sources.base, else below one
/// of sources.roots. Where there are roots, a path that leaves them, by itself or by a symbolic
/// link, is refused with the same words whether or not a file is there. Messages hold `name` only.
std::optional<std::filesystem::path> find_file(const std::string& name, const std::string& where,
                                               const Sources& sources, Findings& findings);

}  // namespace hoodoo::scene
