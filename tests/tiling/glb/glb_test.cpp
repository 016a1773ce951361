#include "tiling/glb/glb.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <string_view>

#include "engine/base/error.hpp"
#include "tests/tiling/lod/meshes.hpp"
#include "tiling/glb/tinygltf.hpp"

namespace hoodoo::glb {
namespace {

using shapes::mesh_of;
using shapes::skirt_of;
using testing::HasSubstr;

Content content(double boundary = 24) {
  Content result;
  result.surface = mesh_of(shapes::height_field({.side = 32, .boundary = boundary}));
  result.skirt = skirt_of(result.surface);
  result.origin = {123456789, -98765, 4096};
  result.step = 1.0 / 64;
  result.materials = {{"shale", {141, 131, 119}, 0, 0.4, 0.6},
                      {"Kalkstein \xC3\xA4", {207, 198, 176}, 0.4, 1, 0.8}};
  return result;
}

/// Every triangle as its corners, each with position, normal and material, starting from the
/// smallest, in order.
template <class Part>
auto corners(const Part& part) {
  using Corner = std::tuple<std::array<std::int32_t, 3>, std::uint16_t>;
  std::vector<std::array<Corner, 3>> all;
  for (const auto& t : part.triangles) {
    std::array<Corner, 3> triangle;
    for (std::size_t c = 0; c < 3; ++c) triangle[c] = {part.points[t[c]], part.materials[t[c]]};
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                triangle.end());
    all.push_back(triangle);
  }
  std::ranges::sort(all);
  return all;
}

class Profile : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, Profile, testing::Values("draco", "meshopt", "plain"),
                         [](const auto& profile) { return std::string(profile.param); });

TEST_P(Profile, DecodesToTheSamePositionsMaterialsAndTriangles) {
  const Content in = content();
  const Decoded out = read(write(in, GetParam()), in.step, "tile");
  EXPECT_EQ(out.origin, in.origin);
  EXPECT_EQ(out.step, in.step);
  EXPECT_EQ(corners(out.surface), corners(in.surface));
  EXPECT_EQ(corners(out.skirt), corners(in.skirt));
}

TEST_P(Profile, GivesEqualNormalsForEqualNormals) {
  const Content in = content();
  Content moved = in;
  for (auto& p : moved.surface.points) p[0] += 8192;  // another grid for the quantisation
  std::ranges::reverse(moved.surface.triangles);
  const Decoded a = read(write(in, GetParam()), in.step, "a");
  const Decoded b = read(write(moved, GetParam()), in.step, "b");
  std::map<std::array<std::int32_t, 3>, Vec3f> normals;
  for (std::size_t i = 0; i < a.surface.points.size(); ++i) {
    normals[a.surface.points[i]] = a.surface.normals[i];
  }
  for (std::size_t i = 0; i < b.surface.points.size(); ++i) {
    auto p = b.surface.points[i];
    p[0] -= 8192;
    ASSERT_TRUE(normals.contains(p));
    EXPECT_EQ(normals[p], b.surface.normals[i]);
  }
}

TEST_P(Profile, TurnsNormalsByLessThanAQuarterDegree) {
  const Content in = content(-1);
  const Decoded out = read(write(in, GetParam()), in.step, "tile");
  std::map<std::array<std::int32_t, 3>, Vec3f> normals;
  for (std::size_t i = 0; i < in.surface.points.size(); ++i) {
    normals[in.surface.points[i]] = in.surface.normals[i];
  }
  for (std::size_t i = 0; i < out.surface.points.size(); ++i) {
    const Vec3f a = normals[out.surface.points[i]], b = out.surface.normals[i];
    EXPECT_GT(a.x * b.x + a.y * b.y + a.z * b.z, 0.99999F);
  }
}

TEST_P(Profile, GivesTheSameBytesEveryTime) {
  EXPECT_EQ(write(content(), GetParam()), write(content(), GetParam()));
}

TEST_P(Profile, IsReadByTinygltfWithBoundsAndCountsThatHold) {
  if (std::string_view(GetParam()) == "meshopt") {
    GTEST_SKIP() << "tinygltf does not know EXT_meshopt_compression; tests/e2e/profiles.test.mjs "
                    "reads it with gltf-transform";
  }
  const Content in = content();
  const auto bytes = write(in, GetParam());
  tinygltf::Model model;
  tinygltf::TinyGLTF loader;
  std::string errors, warnings;
  ASSERT_TRUE(loader.LoadBinaryFromMemory(&model, &errors, &warnings,
                                          reinterpret_cast<const unsigned char*>(bytes.data()),
                                          static_cast<unsigned>(bytes.size())))
      << errors;
  EXPECT_EQ(errors + warnings, "");
  ASSERT_EQ(model.meshes.at(0).primitives.size(), 2U);
  for (const auto& primitive : model.meshes[0].primitives) {
    const auto& accessor =
        model.accessors.at(static_cast<std::size_t>(primitive.attributes.at("POSITION")));
    const auto& view = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
    const auto& data = model.buffers.at(static_cast<std::size_t>(view.buffer)).data;
    std::vector<std::array<float, 3>> positions(accessor.count);
    ASSERT_LE(view.byteOffset + accessor.count * 12, data.size());
    std::memcpy(positions.data(), data.data() + view.byteOffset, accessor.count * 12);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto along = [&](const auto& p) { return p[axis]; };
      const auto low = std::ranges::min(positions, {}, along)[axis];
      const auto high = std::ranges::max(positions, {}, along)[axis];
      EXPECT_EQ(accessor.minValues[axis], static_cast<double>(low));
      EXPECT_EQ(accessor.maxValues[axis], static_cast<double>(high));
    }
  }
  EXPECT_TRUE(model.extensions.contains("EXT_structural_metadata"));
}

TEST(Glb, TellsItsStepToWhoDoesNotKnowIt) {
  const Content in = content();
  const Decoded out = read(write(in, "draco"), 0, "tile");
  EXPECT_EQ(out.step, in.step);
  EXPECT_EQ(out.origin, in.origin);
}

TEST(Glb, StandsUprightWithYUp) {
  Content in = content(-1);
  in.origin = {64, 128, 640};
  const auto bytes = write(in, "plain");
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_THAT(text, HasSubstr(R"("translation":[1.0,10.0,-2.0])"));
}

TEST(Glb, DecodesExactlyAtEveryStepAndExtent) {
  for (const double step : {1.0 / 65536, 1.0 / 1024, 1.0 / 256, 0.125, 4.0}) {
    for (int bits = 1; bits <= 22; ++bits) {
      const auto extent = (std::int32_t{1} << bits) - 1;
      Content in = content(-1);
      in.step = step;
      in.skirt = {};
      for (auto& p : in.surface.points) {
        const auto seed = random_bits(3U, p[0], p[1]);
        for (std::uint64_t a = 0; a < 3; ++a) {
          p[a] = static_cast<std::int32_t>(random_bits(seed, a) %
                                           static_cast<std::uint64_t>(extent + 1)) -
                 77;
        }
      }
      const auto points = [](const auto& part) {  // few bits: many vertices at one position
        std::vector<std::array<std::array<std::int32_t, 3>, 3>> all;
        for (const auto& [a, b, c] : part.triangles) {
          all.push_back({part.points[a], part.points[b], part.points[c]});
          std::ranges::sort(all.back());
        }
        std::ranges::sort(all);
        return all;
      };
      const auto out = read(write(in, "draco"), step, "tile");
      EXPECT_TRUE(points(out.surface) == points(in.surface)) << bits << " bits of " << step;
    }
  }
}

TEST(Glb, HoldsExtentsOfTwentyThreeBitsAndRefusesMore) {
  Content in;
  in.step = 1.0 / 1024;
  in.materials = content().materials;
  in.surface.points = {{0, 0, 0}, {(1 << 23) - 1, 1, 5}, {3, (1 << 23) - 1, 1}};
  in.surface.normals.assign(3, {0, 0, 1});
  in.surface.colors.assign(3, {1, 2, 3, 255});
  in.surface.materials.assign(3, 1);
  in.surface.triangles = {{0, 1, 2}};
  const Decoded out = read(write(in, "draco"), in.step, "tile");
  EXPECT_EQ(corners(out.surface), corners(in.surface));
  const auto refused = [&](const char* profile) {
    try {
      write(in, profile);
      return false;
    } catch (const Error& error) {
      return error.fault == Fault::limit;
    }
  };
  in.surface.points[2][1] = 1 << 23;
  EXPECT_TRUE(refused("draco"));
  EXPECT_FALSE(refused("plain"));
  in.surface.points[2][1] = 1 << 24;
  EXPECT_TRUE(refused("plain"));
}

TEST(Glb, WritesIdsOfTwoBytesForManyMaterials) {
  Content in = content();
  in.materials.resize(400, in.materials.front());
  for (auto& id : in.surface.materials) id = static_cast<std::uint16_t>(id + 350);
  for (const char* profile : {"draco", "plain"}) {
    EXPECT_EQ(corners(read(write(in, profile), in.step, "tile").surface), corners(in.surface));
  }
}

void expect_refused(const std::vector<std::byte>& bytes, double step = 1.0 / 64) {
  try {
    read(bytes, step, "some.glb");
  } catch (const Error& error) {
    EXPECT_TRUE(error.fault == Fault::bad_input || error.fault == Fault::limit);
    EXPECT_THAT(error.what(), HasSubstr("some.glb"));
  }
}

TEST_P(Profile, NeverFallsOverDamagedBytes) {
  const auto whole = write(content(), GetParam());
  EXPECT_THROW(read({}, 1, "some.glb"), Error);
  EXPECT_THROW(read(whole, 1.0 / 8, "some.glb"), Error);  // off that grid
  for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 97) {
    const std::vector<std::byte> cut(whole.begin(),
                                     whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THROW(read(cut, 1.0 / 64, "some.glb"), Error);
  }
  for (std::uint64_t k = 0; k < 2000; ++k) {
    auto bytes = whole;
    const auto bits = random_bits(11U, k);
    // Most of the damage into the JSON and the head of the Draco data.
    const auto at = bits % (k % 2 == 0 ? std::min<std::size_t>(bytes.size(), 6000) : bytes.size());
    bytes[at] ^= static_cast<std::byte>(1 + (bits >> 40) % 255);
    SCOPED_TRACE(k);
    expect_refused(bytes);
  }
}

TEST(Glb, RefusesOtherFilesByName) {
  const std::string text = "glTF is not this";
  const auto bytes = std::as_bytes(std::span(text));
  try {
    read({bytes.begin(), bytes.end()}, 1, "some.glb");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::bad_input);
    EXPECT_EQ(error.problems.front().where, "some.glb");
  }
}

}  // namespace
}  // namespace hoodoo::glb
