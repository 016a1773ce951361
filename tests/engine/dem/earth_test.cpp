#include "engine/dem/earth.hpp"

#include <gtest/gtest.h>
#include <proj.h>

#include <random>
#include <string>

#include "engine/base/error.hpp"
#include "engine/dem/crs.hpp"

namespace hoodoo::dem {
namespace {

Frame frame_at(const char* crs, double x, double y, const char* vertical, double unit = 1) {
  return {crs, unit, x, y, vertical};
}

std::vector<Vec3> points_over(double wide) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> along(0, wide), up(-200, 4000);
  std::vector<Vec3> points;
  for (int i = 0; i < 300; ++i) points.push_back({along(random), along(random), up(random)});
  return points;
}

Vec3 geocentric(const Earth& earth, const Vec3& p) {
  const auto m = earth.transform();
  const auto row = [&](std::size_t i) {
    return m[i] * p.x + m[4 + i] * p.y + m[8 + i] * p.z + m[12 + i];
  };
  return {row(0), row(1), row(2)};
}

/// What PROJ's own cs2cs does: one operation from `source` to EPSG:4978.
double largest_distance(const Frame& frame, const char* source) {
  const ProjContext context;
  const PjPointer stated(proj_create_crs_to_crs(context.get(), source, "EPSG:4978", nullptr));
  const PjPointer pj(proj_normalize_for_visualization(context.get(), stated.get()));
  const Earth earth(frame);
  const auto points = points_over(50'000);
  const auto places = earth.places(points);
  double most = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto p =
        proj_trans(pj.get(), PJ_FWD,
                   proj_coord((points[i].x + frame.origin_x) / frame.unit,
                              (points[i].y + frame.origin_y) / frame.unit, points[i].z, HUGE_VAL));
    most =
        std::max(most, length(geocentric(earth, places[i].at) - Vec3{p.xyz.x, p.xyz.y, p.xyz.z}));
  }
  return most;
}

TEST(Earth, AgreesWithProjOverFiftyKilometres) {
  EXPECT_LT(
      largest_distance(frame_at("EPSG:32632", 350'000, 5'100'000, "EPSG:5773"), "EPSG:32632+5773"),
      0.0005);
  EXPECT_LT(largest_distance(frame_at("EPSG:32719", 240'000, 8'000'000, "ellipsoid"), "EPSG:32719"),
            0.0005);
  // Feet in the plane, metres of height.
  constexpr double foot = 1200.0 / 3937;
  EXPECT_LT(
      largest_distance(frame_at("EPSG:2229", 1'970'000, 560'000, "ellipsoid", foot), "EPSG:2229"),
      0.0005);
}

TEST(Earth, CountsHeightsFromTheDatum) {
  // EGM96 lies 23.4 m or so below the ellipsoid in southern Utah: heights differ by that.
  const Earth geoid(frame_at("EPSG:32612", 300'000, 4'100'000, "EPSG:5773"));
  const Earth ellipsoid(frame_at("EPSG:32612", 300'000, 4'100'000, "ellipsoid"));
  const Vec3 p{1000, 2000, 1500};
  const double apart = length(geocentric(geoid, geoid.places({&p, 1})[0].at) -
                              geocentric(ellipsoid, ellipsoid.places({&p, 1})[0].at));
  EXPECT_NEAR(apart, 23, 3);
}

TEST(Earth, FindsThePointsAgain) {
  const Earth earth(frame_at("EPSG:32632", 350'000, 5'100'000, "EPSG:5773"));
  const auto points = points_over(80'000);
  std::vector<Vec3> local;
  for (const auto& place : earth.places(points)) local.push_back(place.at);
  const auto again = earth.scene(local);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT(length(again[i] - points[i]), 1e-5);
}

TEST(Earth, TellsHowPointsMove) {
  const Earth earth(frame_at("EPSG:32632", 350'000, 5'100'000, "ellipsoid"));
  for (const Vec3& p : points_over(50'000)) {
    const auto here = earth.places({&p, 1})[0];
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 beside = p;
      beside[axis] += 10;
      const Vec3 moved = (earth.places({&beside, 1})[0].at - here.at) * 0.1;
      EXPECT_LT(length(moved - here.axes[static_cast<std::size_t>(axis)]), 1e-4);
    }
  }
}

TEST(Earth, StandsInARigidFrame) {
  const Earth earth(frame_at("EPSG:32612", 300'000, 4'100'000, "ellipsoid"));
  const auto m = earth.transform();
  const Vec3 east{m[0], m[1], m[2]}, north{m[4], m[5], m[6]}, up{m[8], m[9], m[10]};
  EXPECT_LT(length(cross(east, north) - up), 1e-12);
  EXPECT_NEAR(length(east), 1, 1e-12);
  EXPECT_EQ(east.z, 0);
  EXPECT_GT(north.z, 0);
  const Vec3 zero;
  EXPECT_LT(length(earth.places({&zero, 1})[0].at), 0.001);
}

std::string refusal(const Frame& frame) {
  try {
    Earth{frame};
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::bad_input);
    return error.what();
  }
  return "";
}

TEST(Earth, RefusesWhatHasNoWayThere) {
  EXPECT_NE(refusal(frame_at("", 0, 0, "ellipsoid")).find("no CRS"), std::string::npos);
  EXPECT_NE(refusal(frame_at("EPSG:32612", 3e5, 4e6, "EPSG:4326")).find("no vertical CRS"),
            std::string::npos);
  EXPECT_NE(refusal(frame_at("EPSG:32612", 3e5, 4e6, "sea level")).find("no vertical CRS"),
            std::string::npos);
  // Its grids are not part of the system's package of PROJ.
  EXPECT_NE(refusal(frame_at("EPSG:32612", 3e5, 4e6, "EPSG:5703")).find(".tif is missing"),
            std::string::npos);
}

}  // namespace
}  // namespace hoodoo::dem
