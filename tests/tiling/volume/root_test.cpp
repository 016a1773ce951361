#include "tiling/volume/root.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

using hoodoo::volume::RootFinder;

namespace {

struct Found {
  double root;
  int evaluations;
};
Found find(const std::function<double(double)>& f) {
  RootFinder finder(f(0), f(1));
  int n = 0;
  for (; !finder.done() && n < 100; ++n) {
    const double t = finder.next();
    EXPECT_GE(t, 0);
    EXPECT_LE(t, 1);
    finder.put(t, f(t));
  }
  return {finder.root(), n};
}

}  // namespace

TEST(RootFinder, FindsEveryRootOfALineAtOnce) {
  for (double root = 0.0005; root < 1; root += 0.001) {
    const auto found = find([&](double t) { return 3 * (root - t); });
    EXPECT_NEAR(found.root, root, 1e-12) << root;
    EXPECT_EQ(found.evaluations, 1) << root;
  }
}

TEST(RootFinder, NeedsFewEvaluationsOfCurvesAndKinks) {
  int evaluations = 0;
  for (double root = 0.0005; root < 1; root += 0.001) {
    for (const double bend : {-0.5, 0.7, 4.0}) {
      const auto found = find([&](double t) {
        const double d = t - root;
        return d + bend * d * d * (bend > 1 ? d : 1);
      });
      EXPECT_NEAR(found.root, root, RootFinder::tolerance) << root << ' ' << bend;
      EXPECT_LE(found.evaluations, 8) << root << ' ' << bend;
      evaluations += found.evaluations;
    }
    const auto kink = find([&](double t) { return t < root ? 4 * (root - t) : root - t; });
    EXPECT_NEAR(kink.root, root, RootFinder::tolerance) << root;
    EXPECT_LE(kink.evaluations, 12) << root;
  }
  EXPECT_LT(evaluations, 4.2 * 3000);
}

TEST(RootFinder, EndsForEveryFunction) {
  const double root = 0.7310585;
  const std::function<double(double)> hard[] = {[=](double t) { return t < root ? 1e-9 : -1.0; },
                                                [=](double t) { return t < root ? 1.0 : -1e-9; },
                                                [=](double t) { return t < root ? 1.0 : -1.0; }};
  for (const auto& f : hard) {
    const auto found = find(f);
    EXPECT_NEAR(found.root, root, RootFinder::tolerance);
    EXPECT_LE(found.evaluations, RootFinder::most_secants + 14);
  }
}

TEST(RootFinder, EndsWhereAFlatFunctionAllButVanishes) {
  const auto flat = [](double t) { return std::pow(0.7310585 - t, 7); };
  const auto found = find(flat);
  EXPECT_LT(std::abs(flat(found.root)), 1e-7);
  EXPECT_LE(found.evaluations, RootFinder::most_secants + 14);
}

TEST(RootFinder, TakesAZeroAtAnEnd) {
  EXPECT_EQ(find([](double t) { return t; }).root, 0);
  EXPECT_EQ(find([](double t) { return 1 - t; }).root, 1);
}

TEST(RootFinder, WorksWhicheverEndIsSolid) {
  EXPECT_NEAR(find([](double t) { return t * t - 0.3; }).root, 0.5477226, RootFinder::tolerance);
  EXPECT_NEAR(find([](double t) { return 0.3 - t * t; }).root, 0.5477226, RootFinder::tolerance);
}
