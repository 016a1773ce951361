#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>

#include "engine/base/error.hpp"
#include "engine/dem/dem.hpp"
#include "tests/engine/dem/written_tiff.hpp"

namespace hoodoo::dem {
namespace {

#ifdef NDEBUG
constexpr bool optimised = true;
#else
constexpr bool optimised = false;
#endif

void read_all(const std::filesystem::path& path) {
  auto raster = Raster::open(path);
  const auto& info = raster->info();
  std::vector<double> pixels;
  for (std::int64_t j = 0; j < info.height; j += 256) {
    for (std::int64_t i = 0; i < info.width; i += 1024) {
      raster->read(i, j, static_cast<int>(std::min<std::int64_t>(1024, info.width - i)),
                   static_cast<int>(std::min<std::int64_t>(256, info.height - j)), pixels);
    }
  }
}

void ingest(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const auto placed = place(*Raster::open(path), {});
  const auto p = Pyramid::ingest(path, placed.frame, placed.spacing, {}, folder);
  p->window(static_cast<int>(p->levels().size()) - 1, p->extent());
}

// Files that broke TIFF readers (GDAL, libtiff, Pillow, exiv2, Go and Rust fuzzing): each ends as a
// good read or as an error of ours that names it, soon.
TEST(HostileTiff, EndsInAGoodReadOrAnErrorNamingTheFile) {
  const char* const data = std::getenv("HOODOO_TEST_DATA");
  const auto root = std::filesystem::path(data ? data : "../shared/data") / "hostile_tiff";
  if (!std::filesystem::exists(root)) GTEST_SKIP() << root << " is not there";
  const ScratchFolder folder;
  int files = 0, good = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    if (!entry.is_regular_file()) continue;
    ++files;
    const auto start = std::clock();
    for (const bool whole : {false, true}) {
      try {
        if (whole) {
          ingest(entry.path(), folder / "cache");
        } else {
          read_all(entry.path());
        }
        good += whole;
      } catch (const Error& error) {
        EXPECT_EQ(error.problems.front().where, entry.path().string());
        EXPECT_NE(error.fault, Fault::internal) << error.what();
        EXPECT_FALSE(error.problems.front().what.empty());
      }
    }
    // Seconds of processor time: the wall's depend on what else the machine does. A build for
    // debugging or under a sanitizer takes its time.
    const double took = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (optimised) {
      EXPECT_LT(took, 10) << entry.path();
    }
  }
  RecordProperty("files", files);
  RecordProperty("good", good);
  EXPECT_GT(files, 200);
  EXPECT_GT(good, 50);
}

}  // namespace
}  // namespace hoodoo::dem
