#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/dem/earth.hpp"
#include "tiling/lod/buckets.hpp"
#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/patch.hpp"

namespace hoodoo::compare {

/// The surface of one tile, ready to be asked what is nearest.
struct Sheet {
  tileset::Patch patch;  // scene frame of the first bake
  std::vector<Vec3f> normals;
  std::vector<std::uint16_t> materials;  // per point, alike within a triangle
  std::set<int> present;                 // of them
  lod::Buckets buckets;

  int material(std::uint32_t triangle) const { return materials[patch.triangles[triangle][0]]; }
};

/// The tiles of one finished bake, read as they are asked for; the last dozen are held.
class Surfaces {
 public:
  /// Errors: bad_input, not_found, when `folder` has no finished bake; or tiles of it are missing
  /// or have another size than the index says, all of them at once.
  explicit Surfaces(const std::filesystem::path& folder);
  Surfaces(const Surfaces&) = delete;
  Surfaces& operator=(const Surfaces&) = delete;

  const tileset::Manifest& manifest() const { return manifest_; }
  /// Moves the bake by `by` [m]: its frame has another origin.
  void shift(const Vec3& by) { shift_ = by; }

  /// Tiles that have a surface.
  const std::map<plan::Key, const tileset::Record*>& tiles() const { return tiles_; }
  Box area(const plan::Key& key) const;    // of the tile in plan
  Box bounds(const plan::Key& key) const;  // of what it holds
  /// Keys of the tiles of `level` whose area has ground in common with `area`.
  std::vector<plan::Key> over(const Box& area, int level) const;
  /// The same of all lattice, with or without a tile.
  std::vector<plan::Key> lattice_over(const Box& area, int level) const;

  /// Errors: not_found, io, bad_input, when the tile is damaged.
  std::shared_ptr<const Sheet> sheet(const plan::Key& key);
  std::uint64_t read() const { return read_; }

 private:
  struct Held {
    std::shared_ptr<const Sheet> sheet;
    std::uint64_t used = 0;
  };
  void check_files() const;
  std::shared_ptr<const Sheet> load(const tileset::Record& record) const;

  std::filesystem::path folder_;
  tileset::Manifest manifest_;
  std::optional<dem::Earth> earth_;
  Vec3 shift_;
  std::map<plan::Key, const tileset::Record*> tiles_;
  std::map<plan::Key, Held> held_;
  std::uint64_t read_ = 0, clock_ = 0;
};

}  // namespace hoodoo::compare
