#include <gtest/gtest.h>

#include "tests/tiling/tileset/world.hpp"

/// What a level loses wholly counts in its error by its size.
namespace hoodoo::tileset {
namespace {

using shapes::Folder;
using shapes::World;

constexpr int units = 256;  // steps per metre

/// Puts a closed box [m, from the tile's origin] beside the surface.
void add_box(surface::Mesh& mesh, const std::array<int, 3>& low, const std::array<int, 3>& high) {
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (unsigned corner = 0; corner < 8; ++corner) {
    std::array<std::int32_t, 3> p{};
    for (std::size_t a = 0; a < 3; ++a) {
      p[a] = units * ((corner >> a & 1) != 0 ? high[a] : low[a]);
    }
    mesh.points.push_back(p);
    mesh.normals.push_back({0, 0, 1});
    mesh.colors.push_back({90, 80, 70, 255});
    mesh.materials.push_back(0);
  }
  constexpr std::uint32_t sides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& [a, b, c, d] : sides) {
    mesh.triangles.push_back({first + a, first + b, first + c});
    mesh.triangles.push_back({first + a, first + c, first + d});
  }
}

/// Errors of four levels whose leaves alone have what `add` puts into one of them.
std::map<plan::Key, double> errors_with(const std::string& name,
                                        const std::function<void(surface::Mesh&)>& add) {
  const Folder folder("thin-" + name);
  World world{.levels = 4};
  world.change = [&](const plan::Key& key, glb::Content& content) {
    if (key == plan::Key{0, 2, 3}) add(content.surface);
  };
  return measure_errors(world.make(folder.path), folder.path, 1);
}

/// Ground of the leaf that it is added to lies within [-20, 20] m.
void expect_at_least(const std::map<plan::Key, double>& errors, double size) {
  for (const auto& key : {plan::Key{1, 1, 1}, plan::Key{2, 0, 0}, plan::Key{3, 0, 0}}) {
    EXPECT_GE(errors.at(key), size) << key.text();
  }
}

TEST(ThinFeature, ThatIsAPillarCountsByItsHeight) {
  const auto errors = errors_with("pillar", [](auto& mesh) {
    add_box(mesh, {7, 7, 0}, {8, 8, 60});
  });
  expect_at_least(errors, 40);
  EXPECT_LT(errors.at({1, 0, 0}), 10) << "where there is none";
}

TEST(ThinFeature, ThatIsAnArchCountsByItsRise) {
  const auto errors = errors_with("arch", [](auto& mesh) {
    add_box(mesh, {3, 7, 0}, {4, 8, 55});
    add_box(mesh, {12, 7, 0}, {13, 8, 55});
    add_box(mesh, {3, 7, 55}, {13, 8, 56});
  });
  expect_at_least(errors, 36);
}

TEST(ThinFeature, ThatIsAFloatingBallCountsByItsSizeAndHeight) {
  const auto errors = errors_with("ball", [](auto& mesh) {
    add_box(mesh, {7, 7, 50}, {9, 9, 52});
  });
  expect_at_least(errors, 32);
}

}  // namespace
}  // namespace hoodoo::tileset
