#include "tiling/plan/plan.hpp"

#include <gtest/gtest.h>

using namespace hoodoo;
using plan::Key;

TEST(Key, ReadsWhatItWrites) {
  const Key key{3, 17, 0};
  EXPECT_EQ(key.text(), "3/17/0");
  EXPECT_EQ(Key::parse("3/17/0"), key);
}

TEST(Key, RefusesWhatIsNoKey) {
  for (const auto* text :
       {"", "3", "3/1", "3/1/2/4", "3/1/2 ", "a/1/2", "-1/0/0", "3//2", "3/1/"}) {
    EXPECT_EQ(Key::parse(text), std::nullopt) << text;
  }
}

TEST(Key, HasTheParentThatCoversItAtTwiceTheSpacing) {
  EXPECT_EQ((Key{0, 5, 8}.parent()), (Key{1, 2, 4}));
  EXPECT_EQ((Key{4, 0, 1}.parent()), (Key{5, 0, 0}));
}

TEST(Lattice, CountsBetween256And511StepsPerCell) {
  for (double spacing = 0.01; spacing < 5000; spacing *= 1.07) {
    const double rounded = dem::rounded_spacing(spacing);
    const plan::Lattice lattice{rounded, dem::step_of(rounded), 128};
    EXPECT_GE(lattice.units(), 256) << spacing;
    EXPECT_LE(lattice.units(), 512) << spacing;
    EXPECT_EQ(lattice.units() * lattice.step0, rounded) << "a whole number of steps";
    EXPECT_NEAR(rounded, spacing, spacing / 512);
  }
}

TEST(Lattice, GivesAParentTheAreaOfItsFourChildren) {
  const plan::Lattice lattice{2.5, dem::step_of(2.5), 128};
  const Box parent = lattice.area({1, 3, 4});
  EXPECT_EQ(parent.min.x, lattice.area({0, 6, 8}).min.x);
  EXPECT_EQ(parent.max.x, lattice.area({0, 7, 8}).max.x);
  EXPECT_EQ(parent.max.y, lattice.area({0, 7, 9}).max.y);
}
