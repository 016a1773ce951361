#include "tests/bench/whole.hpp"

#include <unistd.h>

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/bench/engine.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/table.hpp"
#include "tiling/bake/tile.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/lod/collapse.hpp"
#include "tiling/lod/lod.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/store/store.hpp"
#include "tiling/surface/mesh.hpp"
#include "tiling/surface/surface.hpp"
#include "tiling/tileset/tileset.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::bench {
namespace {

namespace fs = std::filesystem;

/// Adds what `step` takes to `seconds`.
template <class Step>
auto timed(double& seconds, Step step) {
  const double from = processor_seconds();
  auto result = step();
  seconds += processor_seconds() - from;
  return result;
}

/// What the stages of one tile take, each by itself.
struct Stages {
  double cut = 0, sample = 0, extract = 0, simplify = 0, shade = 0, skirts = 0, write = 0;
};

struct Whole {
  double bake = 0, errors = 0;            // as bakes run
  double collapse = 0, encode = 0;        // the floor
  std::uint64_t triangles = 0, kept = 0;  // before and after simplification

  double floor() const { return collapse + encode; }
};

class WholeBake {
 public:
  explicit WholeBake(const Scene& scene) {
    scene_.bake.tile_cells = 128;
    scene_.ground = ground_of(list_of(scene.balls, {}));
    const auto table = std::make_shared<Table>(scene);
    scene_.extent = table->extent();
    scene_.pyramids.push_back(table);
    plan_ = plan::make(scene_);
    folder_ = fs::temp_directory_path() / ("hoodoo-bench-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  ~WholeBake() { fs::remove_all(folder_); }
  WholeBake(const WholeBake&) = delete;
  WholeBake& operator=(const WholeBake&) = delete;

  Whole run() {
    Whole whole;
    tileset::Index index;
    index.lattice = plan_.lattice;
    index.levels = plan_.levels;
    index.tiles = plan_.tiles;
    index.read = [this](const plan::Tile& tile) {
      return *bake::find_finished(tile.slice, folder_);
    };
    for (auto& tile : index.tiles) {
      const auto record = timed(whole.bake, [&] {
        const auto slice = slice::cut(scene_, plan_.lattice, tile.key());
        return bake::bake_tile(slice, slice.hash(), scene_.pyramids, nullptr, folder_);
      });
      if (!record.empty) add_floor(record, whole);
      tile.slice = record.slice;
      tile.finished = true;
      tile.empty = record.empty;
    }
    timed(whole.errors, [&] {
      tileset::measure_errors(index, folder_, 1);
      return 0;
    });
    return whole;
  }

  Stages stages() const {
    Stages seconds;
    for (const auto& tile : plan_.tiles) {
      const auto key = tile.key();
      const auto slice = timed(seconds.cut, [&] { return slice::cut(scene_, plan_.lattice, key); });
      slice::Land land(slice, scene_.pyramids);
      const auto volume = timed(seconds.sample, [&] { return volume::sample(land); });
      const auto whole = timed(seconds.extract, [&] { return surface::extract(volume, land); });
      if (whole.triangles.empty()) continue;
      const auto simple = timed(seconds.simplify, [&] {
        return lod::simplify(whole, slice.simplify / slice.step(), slice.lattice.units());
      });
      glb::Content content;
      content.step = slice.step();
      content.materials = slice.ground.materials;
      for (std::size_t a = 0; a < 3; ++a) {
        content.origin[a] = volume.low()[a] * slice.lattice.units();
      }
      content.surface = timed(seconds.shade,
                              [&] { return surface::shade(simple.surface, land, content.origin); });
      content.skirt = timed(seconds.skirts, [&] {
        return surface::skirts(simple.surface, content.surface, land, content.origin,
                               2 * slice.lattice.spacing(key.level + 1));
      });
      timed(seconds.write, [&] { return glb::write(content, slice.profile); });
    }
    return seconds;
  }

 private:
  /// The tile's whole surface through meshoptimizer once, at the target that simplification tries
  /// first, and its finished meshes through Draco.
  void add_floor(const tileset::Record& record, Whole& whole) const {
    const auto slice = slice::cut(scene_, plan_.lattice, record.key);
    slice::Land land(slice, scene_.pyramids);
    const auto surface = surface::extract(volume::sample(land), land);
    const double target = lod::first_share * slice.simplify / slice.step();
    const std::vector<bool> none_frozen(surface.triangles.size());
    timed(whole.collapse, [&] { return lod::Collapse(surface).run(target, none_frozen); });
    whole.triangles += surface.triangles.size();
    whole.kept += record.triangles;
    const auto read = glb::read(store::get_tile(folder_, record.content), slice.step(), "a tile");
    glb::Content content;
    content.step = slice.step();
    content.origin = read.origin;
    content.materials = slice.ground.materials;
    const auto take = [](const glb::Decoded::Part& part) {
      surface::Mesh mesh;
      mesh.points = part.points;
      mesh.normals = part.normals;
      mesh.colors = part.colors;
      mesh.materials = part.materials;
      mesh.triangles = part.triangles;
      return mesh;
    };
    content.surface = take(read.surface);
    content.skirt = take(read.skirt);
    timed(whole.encode, [&] { return glb::write(content, slice.profile); });
  }

  scene::Scene scene_;
  plan::Plan plan_;
  fs::path folder_;
};

void print(const char* what, double seconds) { fmt::print("  {:56} {:9.2f} s\n", what, seconds); }

}  // namespace

void compare_whole() {
  const Scene scene = sea();
  WholeBake bake(scene);
  const Whole whole = bake.run();
  fmt::print("sea, baked whole: {} triangles, {} after simplification\n", whole.triangles,
             whole.kept);
  print("the bake, from slice to file", whole.bake);
  print("its error pass", whole.errors);
  print("the same surfaces through meshoptimizer once", whole.collapse);
  print("the same tiles through Draco at speed 5", whole.encode);
  ratio("whole bake / meshoptimizer and Draco alone", whole.bake / whole.floor(), "<= 1.6");
  ratio("error pass / meshoptimizer and Draco alone", whole.errors / whole.floor(), "<= 0.4");
  const Stages stages = bake.stages();
  print("stage: slice cut", stages.cut);
  print("stage: signs and crossings", stages.sample);
  print("stage: dual contouring", stages.extract);
  print("stage: simplified and examined", stages.simplify);
  print("stage: normals and colours", stages.shade);
  print("stage: skirts", stages.skirts);
  print("stage: encoded", stages.write);
}

}  // namespace hoodoo::bench
