// Bakes small scenes to a digest each. They are the same on every compiler, processor and build
// type; a change that means to alter tiles accepts new ones with HOODOO_BLESS=1.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/base/file.hpp"
#include "engine/base/hash.hpp"
#include "engine/scene/sample.hpp"
#include "tiling/bake/bake.hpp"

using namespace hoodoo;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

const fs::path here = fs::path(HOODOO_GOLDEN_FOLDER);

/// A folder with a DEM of 100 x 100 pixels of 8 m; removed at the end.
class Golden : public testing::TestWithParam<std::string> {
 protected:
  Golden()
      : folder_(fs::temp_directory_path() /
                ("hoodoo-golden-" + GetParam() + "-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    scene::write_sample_dem(folder_ / "dem.tif", {100, 8, 1});
  }
  ~Golden() override { fs::remove_all(folder_); }

  /// Of all tiles and indexes. bake.json is left out: it names the DEM by its compressed bytes.
  std::string digest() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "out")) {
      const auto name = fs::relative(entry.path(), folder_ / "out").string();
      if (!entry.is_regular_file() || name == "bake.json" || name.starts_with(".hoodoo")) continue;
      files[name] = sha256(read_file(entry.path(), 1U << 30)).hex();
    }
    EXPECT_GT(files.size(), 5U);
    return sha256(json(files).dump()).hex();
  }

  fs::path folder_;
};

}  // namespace

TEST_P(Golden, BakesToTheDigestThatWasAccepted) {
  const auto scene = json::parse(read_file(here / (GetParam() + ".json"), 1U << 20));
  ASSERT_TRUE(bake::run(scene, {folder_, {}}, folder_ / "out", {}).complete);
  const auto file = here / "digests.json";
  auto digests = json::parse(read_file(file, 1U << 20));
  if (std::getenv("HOODOO_BLESS") != nullptr) {
    digests[GetParam()] = digest();
    write_file(file, digests.dump(2) + "\n");
  }
  EXPECT_EQ(digests.value(GetParam(), ""), digest()) << "run with HOODOO_BLESS=1 to accept it";
}

INSTANTIATE_TEST_SUITE_P(Scenes, Golden, testing::Values("ground", "features", "regions"),
                         [](const auto& scene) { return scene.param; });
