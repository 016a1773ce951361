#include "tiling/volume/root.hpp"

#include <gtest/gtest.h>

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

TEST(RootFinder, EndsWithinItsToleranceForEveryRootOfALine) {
  for (double root = 0.0005; root < 1; root += 0.001) {
    const auto found = find([&](double t) { return 3 * (root - t); });
    EXPECT_NEAR(found.root, root, RootFinder::tolerance) << root;
    EXPECT_LE(found.evaluations, 6) << root;
  }
}

TEST(RootFinder, NeedsAtMostOneEvaluationMoreThanBisection) {
  const double root = 0.7310585;
  const std::function<double(double)> hard[] = {[=](double t) { return t < root ? 1e-9 : -1.0; },
                                                [=](double t) { return t < root ? 1.0 : -1e-9; },
                                                [=](double t) {
                                                  const double d = root - t;
                                                  return d * d * d * d * d * d * d;
                                                },
                                                [=](double t) { return t < root ? 1.0 : -1.0; }};
  for (const auto& f : hard) {
    const auto found = find(f);
    EXPECT_NEAR(found.root, root, RootFinder::tolerance);
    EXPECT_LE(found.evaluations, 15);
  }
}

TEST(RootFinder, WorksWhicheverEndIsSolid) {
  EXPECT_NEAR(find([](double t) { return t * t - 0.3; }).root, 0.5477226, RootFinder::tolerance);
  EXPECT_NEAR(find([](double t) { return 0.3 - t * t; }).root, 0.5477226, RootFinder::tolerance);
}
