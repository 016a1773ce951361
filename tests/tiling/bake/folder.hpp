#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/base/file.hpp"
#include "engine/base/hash.hpp"
#include "engine/scene/sample.hpp"
#include "tiling/bake/bake.hpp"

namespace hoodoo {

/// A folder with a small DEM, and bakes beside it; removed at the end.
class BakeTest : public testing::Test {
 protected:
  BakeTest() {
    static std::atomic<int> serial{0};
    folder_ = std::filesystem::temp_directory_path() /
              ("hoodoo-bake-test-" + std::to_string(::getpid()) + "-" + std::to_string(++serial));
    std::filesystem::create_directories(folder_);
    scene::SampleDem sample;
    sample.pixels = 100;
    sample.spacing = 8;
    scene::write_sample_dem(folder_ / "dem.tif", sample);
  }
  ~BakeTest() override { std::filesystem::remove_all(folder_); }

  /// 4 x 4 leaves of 32 cells, with a ball half sunk into the ground.
  static nlohmann::json scene(double ball_x = 300) {
    return {{"hoodoo", 1},
            {"name", "bake test"},
            {"terrains", {{{"id", "land"}, {"dem", "dem.tif"}}}},
            {"geology", {{"type", "strata"}, {"wavelength", 30}}},
            {"operations",
             {{{"id", "ball"},
               {"op", "union"},
               {"tree",
                {{"type", "sphere"},
                 {"center", {{"xy", {ball_x, 300}}, {"ground", 0}}},
                 {"radius", 60},
                 {"falloff", 20}}}}}},
            {"bake", {{"tile_cells", 32}}}};
  }

  bake::Report run(const nlohmann::json& scene, const std::string& name,
                   bake::Settings settings = {}) {
    return bake::run(scene, {folder_, {}}, folder_ / name, settings);
  }

  /// Every file below a bake's folder, by relative name, with its digest.
  std::map<std::string, std::string> files(const std::string& name) const {
    std::map<std::string, std::string> found;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / name)) {
      if (!entry.is_regular_file()) continue;
      found[std::filesystem::relative(entry.path(), folder_ / name).string()] =
          sha256(read_file(entry.path(), 1u << 30)).hex();
    }
    return found;
  }

  std::filesystem::path folder_;
};

}  // namespace hoodoo
