#include "engine/tree/region.hpp"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>

#include "engine/base/file.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

class RegionJson : public SceneTest {
 protected:
  static json with(const json& region) {
    auto scene = minimal();
    scene["operations"] = {
        {{"type", "sphere"}, {"center", {500, 500, 100}}, {"radius", 50}, {"region", region}}};
    return scene;
  }
  static std::shared_ptr<const tree::Region> region(const char* text) {
    return opened(with(json::parse(text))).ground.steps.at(0).region;
  }
  static std::vector<std::string> of(const char* text) {
    return texts(problems(with(json::parse(text))));
  }
  /// 3 x 2 pixels: first channel 0 51 255 in the north, 255 0 0 in the south.
  template <class Sample>
  static void paint(const std::string& name, int channels, Sample white) {
    const auto type = OIIO::TypeDesc(OIIO::BaseTypeFromC<Sample>::value);
    OIIO::ImageSpec spec(3, 2, channels, type);
    std::vector<Sample> pixels;
    for (const double v : {0.0, 0.2, 1.0, 1.0, 0.0, 0.0}) {
      for (int c = 0; c < channels; ++c) {
        pixels.push_back(static_cast<Sample>((c == 0 ? v : 1.0) * white));
      }
    }
    const auto out = OIIO::ImageOutput::create(name);
    ASSERT_TRUE(out->open((folder() / name).string(), spec));
    ASSERT_TRUE(out->write_image(type, pixels.data()));
  }
};

TEST_F(RegionJson, MakesABox) {
  const auto made = region(R"({"type": "box", "min": [0, 1, 2], "max": [3, 4, 5], "feather": 6})");
  EXPECT_EQ(made->box, (Box{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_EQ(made->feather, 6);
}

TEST_F(RegionJson, MakesAPolygon) {
  const auto made = region(R"({"type": "polygon", "points": [[0, 0], [9, 0], [0, 9]]})");
  EXPECT_EQ(made->polygon.size(), 3U);
  EXPECT_EQ(made->box, Box::everywhere());
  EXPECT_EQ(made->feather, 1);
}

TEST_F(RegionJson, MakesARangeOfAltitudes) {
  const auto made = region(R"({"type": "altitude", "range": [-5, 40]})");
  EXPECT_EQ(made->box.min.z, -5);
  EXPECT_EQ(made->box.max.z, 40);
  EXPECT_EQ(made->box.min.x, -Box::infinity);
}

TEST_F(RegionJson, ReadsAPaintedMaskFromTheSouth) {
  paint<std::uint8_t>("grey8.png", 1, 255);
  paint<std::uint16_t>("grey16.png", 1, 65535);
  paint<std::uint8_t>("colour.png", 4, 255);
  paint<std::uint16_t>("colour.tif", 3, 65535);
  for (const std::string name : {"grey8.png", "grey16.png", "colour.png", "colour.tif"}) {
    const auto made = region(
        (R"({"type": "mask", "min": [0, 10], "max": [30, 40], "image": ")" + name + "\"}").c_str());
    const auto& mask = made->mask;
    EXPECT_EQ(mask.width, 3);
    EXPECT_EQ(mask.height, 2);
    EXPECT_EQ(mask.x0, 0);
    EXPECT_EQ(mask.y1, 40);
    EXPECT_THAT(mask.weights,
                ElementsAre(1.0F, 0.0F, 0.0F, 0.0F, testing::FloatNear(0.2F, 1e-5F), 1.0F))
        << name;
  }
}

TEST_F(RegionJson, IsRefusedWhereItIsWrong) {
  EXPECT_THAT(of(R"({"type": "bocks"})"), ElementsAre(HasSubstr("/operations/0/region/type: ")));
  EXPECT_THAT(of(R"({"type": "box", "min": [0, 0, 0], "max": [1, 0, 1]})"),
              ElementsAre(HasSubstr("/operations/0/region/max/1: ")));
  EXPECT_THAT(of(R"({"type": "polygon", "points": [[0, 0], [1, 1]]})"),
              ElementsAre(HasSubstr("/operations/0/region/points: ")));
  EXPECT_THAT(of(R"({"type": "polygon", "points": [[0, 0], [1, 1], [2, 2]]})"),
              ElementsAre(HasSubstr("encloses no area")));
  EXPECT_THAT(of(R"({"type": "altitude", "range": [4, 3]})"),
              ElementsAre(HasSubstr("/operations/0/region/range: must rise")));
  EXPECT_THAT(of(R"({"type": "altitude", "range": [3, 4], "fether": 1})"),
              ElementsAre(HasSubstr("\"feather\"")));
}

TEST_F(RegionJson, RefusesAnImageThatIsNone) {
  constexpr auto mask = R"({"type": "mask", "image": "mask.png", "min": [0, 0], "max": [9, 9]})";
  EXPECT_THAT(of(mask), ElementsAre("/operations/0/region/image: no file \"mask.png\""));
  write_file(folder() / "mask.png", "not a picture");
  EXPECT_THAT(of(mask), ElementsAre(HasSubstr("is neither PNG nor TIFF")));
  write_file(folder() / "mask.png", "\x89PNG\r\n\x1a\n and then nothing");
  EXPECT_THAT(of(mask), ElementsAre(HasSubstr("cannot be read")));
}

TEST_F(RegionJson, RefusesMorePixelsThanTheLimit) {
  // 60000 x 60000 pixels that were never written.
  const std::string head("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xea\x60\0\0\xea\x60\x08\0\0\0\0", 29);
  write_file(folder() / "wide.png", head + std::string("\xa5\xb9\x2a\x9e\0\0\0\x10IDAT", 12));
  const auto found = of(R"({"type": "mask", "image": "wide.png", "min": [0, 0], "max": [9, 9]})");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0], HasSubstr("60000 x 60000 pixels"));
}

}  // namespace
}  // namespace hoodoo::scene
