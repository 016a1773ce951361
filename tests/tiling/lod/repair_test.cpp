#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/tiling/lod/shapes.hpp"
#include "tiling/lod/collapse.hpp"
#include "tiling/lod/examine.hpp"

namespace hoodoo::lod {
namespace {

constexpr std::size_t any_number = 100'000;

Faces collapsed(const surface::Surface& surface, double target) {
  Faces faces = Collapse(surface).run(target, std::vector<bool>(surface.triangles.size()));
  drop_fins(faces, surface.points.size());
  turn_chords(faces, surface.planes);
  return faces;
}

/// What `examine` and `unfold` find.
Findings all_findings(const Original& input, Faces& faces, double error) {
  const auto folds = unfold(input, faces, error);
  Findings findings = examine(input, faces, error, any_number);
  findings.faults.insert(findings.faults.end(), folds.begin(), folds.end());
  return findings;
}

std::set<Fault::Kind> kinds_of(const Findings& findings) {
  std::set<Fault::Kind> kinds;
  for (const auto& fault : findings.faults) kinds.insert(fault.kind);
  return kinds;
}

/// Rough ground collapsed a little too far: what is said to be good after mending is found good by
/// a whole examination, too, and most is.
TEST(Repair, EndsWithWhatAWholeExaminationFindsGood) {
  int faulty = 0, mended = 0;
  std::set<Fault::Kind> kinds;
  for (int part = 0; part < 12; ++part) {
    const auto before =
        shapes::height_field({.side = 48, .octaves = 6, .height = 30, .x0 = 48 * part});
    const Original input(before);
    for (const double error : {25.6, 60.0, 128.0}) {
      Faces faces = collapsed(before, 0.6 * error);
      const auto triangles = faces.triangles.size();
      const Findings found = all_findings(input, faces, error);
      if (found.good() || found.torn || kinds_of(found).contains(Fault::Kind::topology)) continue;
      ++faulty;
      kinds.merge(kinds_of(found));
      const Findings after = repair(input, faces, error, found);
      if (!after.good()) continue;
      ++mended;
      const Findings again = all_findings(input, faces, error);
      EXPECT_TRUE(again.good()) << "part " << part << ", error " << error;
      EXPECT_LE(again.error, after.error);
      EXPECT_LE(after.error, error);
      EXPECT_LT(faces.triangles.size(), triangles + 40 * found.faults.size());
    }
  }
  EXPECT_GE(faulty, 10);
  EXPECT_GT(2 * mended, faulty);
  EXPECT_TRUE(kinds.contains(Fault::Kind::missed));
  EXPECT_TRUE(kinds.contains(Fault::Kind::strayed));
}

TEST(Repair, LeavesATopologicalFaultToOthers) {
  const auto ground = shapes::height_field({.side = 24, .octaves = 2});
  const Original input(ground);
  Faces faces = collapsed(ground, 10);
  faces.triangles.pop_back();
  faces.materials.pop_back();
  const Findings found = all_findings(input, faces, 50);
  ASSERT_TRUE(kinds_of(found).contains(Fault::Kind::topology));
  const auto triangles = faces.triangles;
  EXPECT_FALSE(repair(input, faces, 50, found).good());
  EXPECT_EQ(faces.triangles, triangles);
}

}  // namespace
}  // namespace hoodoo::lod
