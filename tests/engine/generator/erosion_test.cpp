#include "engine/generator/erosion.hpp"

#include <gtest/gtest.h>

namespace hoodoo::generator {
namespace {

// Paris et al. 2019, section 6.1: no erosion without stress, beta on the hardest rock.
TEST(ErosionEffect, IsTheFormulaOfThePaper) {
  for (const double rho : {0.0, 0.3, 1.0}) {
    for (const double beta : {0.0, 0.2, 1.0}) EXPECT_EQ(erosion_effect(rho, 0, beta), 0);
  }
  EXPECT_EQ(erosion_effect(1, 1, 0.25), 0.25);
  EXPECT_EQ(erosion_effect(0, 1, 0.25), 1);
  EXPECT_DOUBLE_EQ(erosion_effect(0.5, 0.5, 0.25), 0.5 * 0.5 * 0.75 + 0.5 * 0.25);
}

}  // namespace
}  // namespace hoodoo::generator
