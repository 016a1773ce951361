#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/engine/hydrology/grids.hpp"

namespace hoodoo::hydrology {
namespace {

namespace fs = std::filesystem;

fs::path data() {
  const char* folder = std::getenv("HOODOO_TEST_DATA");
  return folder == nullptr ? fs::path() : fs::path(folder);
}
fs::path oracle() { return data() / "oracle"; }

/// A raster in the ASCII form of ESRI; its cells count as 1 m wide.
Grid read_ascii(const fs::path& path, bool mark_nodata) {
  std::ifstream file(path);
  std::string key;
  double value = 0, nodata = 0;
  std::int32_t width = 0;
  for (int line = 0; line < 6; ++line) {
    file >> key >> value;
    if (key == "ncols") width = static_cast<std::int32_t>(value);
    if (key == "NODATA_value") nodata = value;
  }
  std::vector<float> z;
  while (file >> value) {
    z.push_back(mark_nodata && value == nodata ? hole : static_cast<float>(value));
  }
  return grid_of(width, std::move(z));
}

/// richdem's directions, clockwise from 1, the west.
std::vector<std::uint8_t> directions(const Grid& codes) {
  constexpr std::array<unsigned, 9> neighbour{0, 4, 3, 2, 1, 0, 7, 6, 5};
  const Neighbours neighbours(codes);
  std::vector<std::uint8_t> to(codes.size());
  for (std::size_t c = 0; c < codes.size(); ++c) {
    if (!codes.valid(c) || codes.z[c] == 0) continue;
    const unsigned k = neighbour[static_cast<std::size_t>(codes.z[c])];
    if ((neighbours.valid(c) >> k & 1) != 0) to[c] = static_cast<std::uint8_t>(1U << k);
  }
  return to;
}

TEST(Oracles, RichdemAccumulatesAlongTheSameDirections) {
  const auto folder = oracle() / "richdem/tests/flow_accum";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no test data";
  int compared = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".d8") continue;
    auto result = entry.path();
    result.replace_extension(".out");
    if (!fs::exists(result)) result.replace_filename("output_east.out");
    const Grid codes = read_ascii(entry.path(), true), expected = read_ascii(result, true);
    const auto drainage = accumulate(codes, directions(codes));
    ASSERT_EQ(drainage.area.size(), expected.size());
    for (std::size_t c = 0; c < expected.size(); ++c) {
      ASSERT_EQ(codes.valid(c), expected.valid(c)) << entry.path() << " cell " << c;
      if (!codes.valid(c)) continue;
      ASSERT_EQ(drainage.area[c], expected.z[c]) << entry.path() << " cell " << c;
    }
    ++compared;
  }
  EXPECT_EQ(compared, 24);
}

TEST(Oracles, RichdemFillsTheSame) {
  const auto folder = oracle() / "richdem/tests/depressions";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no test data";
  Grid grid = read_ascii(folder / "testdem1.dem", true);
  const Grid expected = read_ascii(folder / "testdem1.all.out", true);
  fill(grid);
  EXPECT_EQ(grid.z, expected.z);
}

TEST(Oracles, TauDemFillsEveryCellTheSame) {
  const auto folder = oracle() / "taudem";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no test data";
  Grid grid = read(folder / "MED_01_01.tif");
  const Grid expected = read(folder / "MED_01_01fel.tif");
  fill(grid);
  std::size_t compared = 0;
  for (std::size_t c = 0; c < grid.size(); ++c) {
    ASSERT_EQ(grid.valid(c), expected.valid(c)) << "cell " << c;
    if (!grid.valid(c)) continue;
    ASSERT_EQ(grid.z[c], expected.z[c]) << "cell " << c;
    ++compared;
  }
  EXPECT_EQ(compared, 299'136U);
}

TEST(Oracles, SagaFillsEveryCellTheSame) {
  const auto folder = oracle() / "saga_mongon";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no test data";
  Grid grid = read(folder / "input.tif");
  const Grid expected = read(folder / "fill0.tif");
  fill(grid);
  for (std::size_t c = 0; c < grid.size(); ++c) {
    if (!grid.valid(c)) continue;
    ASSERT_EQ(grid.z[c], expected.z[c]) << "cell " << c;
  }
}

TEST(Oracles, SagaSharesAreaTheSameAwayFromTheEdge) {
  const auto folder = oracle() / "saga_mongon";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no test data";
  const Grid grid = read(folder / "fill.tif"), mask = read(folder / "mask_no_edge_influence.tif");
  const Grid expected = read(folder / "mfd_freeman_p1.1.tif");
  const auto drainage = accumulate(grid, receivers(grid, Routing::freeman));
  const double cell = grid.area(0);
  std::size_t compared = 0;
  for (std::size_t c = 0; c < grid.size(); ++c) {
    if (mask.z[c] != 1) continue;
    const auto cells = static_cast<double>(expected.z[c]);
    ASSERT_NEAR(static_cast<double>(drainage.area[c]) / cell, cells, 1e-5 * cells) << "cell " << c;
    ++compared;
  }
  EXPECT_GT(compared, 1'000U);
}

TEST(Oracles, NoPitIsLeftInARealDemAndNothingIsLowered) {
  const auto folder = data() / "dem";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no test data";
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".tif") continue;
    SCOPED_TRACE(entry.path().filename());
    const Grid before = read(entry.path());
    Grid after = before;
    fill(after);
    const auto to = receivers(after, Routing::d8);
    const Neighbours neighbours(after);
    for (std::size_t c = 0; c < after.size(); ++c) {
      if (!after.valid(c)) continue;
      ASSERT_GE(after.z[c], before.z[c]);
      ASSERT_TRUE(to[c] != 0 || neighbours.valid(c) != 0xff) << "water stays at cell " << c;
    }
  }
}

}  // namespace
}  // namespace hoodoo::hydrology
