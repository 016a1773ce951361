#pragma once
#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <vector>

#include "tiling/plan/plan.hpp"

namespace hoodoo::bake {

struct MergeSettings {
  int threads = 1;
  std::stop_token stop;
};

struct MergeReport {
  std::uint64_t tiles = 0;         // in the merged index
  std::uint64_t copied = 0;        // of these, those that were not in `into` before
  std::vector<plan::Key> missing;  // planned, but in no part
};

/// Joins bakes of parts of one plan, each in a folder of its own, into the folder `into`, which may
/// hold a bake of the same plan already. When all tiles are there, every file in it is the same as
/// if one run had baked all of them; until then its index holds what there is.
///
/// Nothing is written unless all parts are of one scene, one plan and one engine. Each tile is
/// checked against its digest as it is copied.
/// Errors: not_found (a folder without an index), bad_input naming what differs or is damaged, io,
/// limit, cancelled.
MergeReport merge(const std::vector<std::filesystem::path>& parts,
                  const std::filesystem::path& into, const MergeSettings& settings);

}  // namespace hoodoo::bake
