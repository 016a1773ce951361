#include "tiling/surface/tables.hpp"

#include <gtest/gtest.h>

#include <bit>

namespace hoodoo::surface {
namespace {

TEST(Cases, HaveAsManySheetsAsTheirLoops) {
  std::array<int, 5> by_sheets{};
  for (const auto& c : cases()) ++by_sheets[static_cast<std::size_t>(c.sheets)];
  EXPECT_EQ(by_sheets, (std::array{2, 162, 82, 8, 2}));
}

TEST(Cases, AreBadAtOneFaceIn36CasesAndFlippingSplitsThatSheet) {
  int bad = 0;
  for (std::size_t mask = 0; mask < 256; ++mask) {
    const auto& c = cases()[mask];
    const auto& flipped = flipped_cases()[mask];
    if (c.bad_face < 0) {
      EXPECT_EQ(flipped.sheet, c.sheet);
      continue;
    }
    ++bad;
    EXPECT_EQ(flipped.sheets, c.sheets + 1);
    EXPECT_EQ(flipped.bad_face, -1);
  }
  EXPECT_EQ(bad, 36);
}

TEST(Cases, PutEveryCrossedEdgeInOneSheetOfAtLeastThree) {
  for (unsigned mask = 0; mask < 256; ++mask) {
    for (const auto* table : {&cases(), &flipped_cases()}) {
      const auto& c = (*table)[mask];
      unsigned all = 0;
      for (std::size_t s = 0; s < static_cast<std::size_t>(c.sheets); ++s) {
        EXPECT_GE(std::popcount(c.edges[s]), 3);
        EXPECT_EQ(all & c.edges[s], 0U);
        all |= c.edges[s];
      }
      for (unsigned edge = 0; edge < 12; ++edge) {
        EXPECT_EQ((all >> edge & 1) != 0, c.sheet[edge] >= 0);
      }
    }
  }
}

TEST(FaceCase, CutsOffSolidCornersOneByOneWhereAmbiguous) {
  const auto pairs = face_case(0b0101);
  ASSERT_EQ(pairs.count, 2);
  EXPECT_EQ(pairs.segments[0].first, 3);
  EXPECT_EQ(pairs.segments[0].second, 0);
  EXPECT_EQ(pairs.segments[1].first, 1);
  EXPECT_EQ(pairs.segments[1].second, 2);
  EXPECT_EQ(face_case(0b1111).count, 0);
  EXPECT_EQ(face_case(0b0111).count, 1);
}

}  // namespace
}  // namespace hoodoo::surface
