#include <gmock/gmock.h>

#include <cmath>
#include <set>

#include "engine/generator/disk_samples.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

/// On the sample coast: 1000 x 1000 m, 8 m pixels.
class Hoodoos : public SceneTest {
 protected:
  static json scene() {
    auto made = minimal();
    made["operations"] = json::parse(R"([{"type": "hoodoos", "id": "h", "distance": 12}])");
    return made;
  }
  static Scene grown(const json& stated, int threads = 1) {
    OpenSettings settings{.cache = folder() / "cache", .ingest = {}};
    settings.ingest.threads = threads;
    settings.keep_marks = true;
    return open(stated, sources(), settings);
  }
  static std::uint64_t count(const Scene& scene, std::string_view what) {
    for (const auto& [name, number] : scene.grown.at(0).counts) {
      if (name == what) return number;
    }
    return 0;
  }
  static const std::vector<generator::Mark>& marks(const Scene& scene) {
    return scene.grown.at(0).marks.at(0).second;
  }
  static std::set<std::pair<double, double>> places(const Scene& scene) {
    std::set<std::pair<double, double>> all;
    for (const auto& mark : marks(scene)) all.insert({mark.at.x, mark.at.y});
    return all;
  }
  /// Rise over run of the terrain.
  static double slope(const Scene& scene, const Vec3& p) {
    const auto window = scene.pyramids[0]->window(0, Box{p, p}.grown(32));
    const double x = window.height(p.x + 8, p.y) - window.height(p.x - 8, p.y);
    const double y = window.height(p.x, p.y + 8) - window.height(p.x, p.y - 8);
    return std::sqrt(x * x + y * y) / 16;
  }
};

TEST_F(Hoodoos, StandApartOnTheGround) {
  const auto made = grown(scene());
  const auto& all = marks(made);
  ASSERT_GT(all.size(), 1000U);
  EXPECT_EQ(count(made, "placed"), all.size());
  double nearest = 1e9;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      nearest = std::min(nearest, std::hypot(all[i].at.x - all[j].at.x, all[i].at.y - all[j].at.y));
    }
    const auto& p = all[i].at;
    EXPECT_NEAR(made.pyramids[0]->window(0, Box{p, p}).height(p.x, p.y), p.z, 1e-9);
  }
  EXPECT_GE(nearest, 12);
  // Samples in a square of the distance; random packing has 0.70.
  EXPECT_NEAR(static_cast<double>(all.size()) * 144 / 1e6, generator::samples_per_square, 0.01);
}

TEST_F(Hoodoos, HoldTheGroundAtTheirFeet) {
  const auto made = grown(scene());
  for (std::size_t i = 0; i < 20; ++i) {
    const auto& p = marks(made)[i * 50].at;
    EXPECT_GT(field(made, p + Vec3{0, 0, 1.5}), 0.5F) << i;
  }
}

TEST_F(Hoodoos, KeepToSlopesAreasAndAltitudes) {
  auto stated = scene();
  const auto all = grown(stated);
  stated["operations"][0]["slope"] = {{"low", 20}, {"high", 40}};
  stated["operations"][0]["altitude"] = {{"low", 30}};
  const auto some = grown(stated);
  ASSERT_GT(marks(some).size(), 20U);
  EXPECT_LT(marks(some).size(), marks(all).size() / 2);
  double sum = 0;
  for (const auto& mark : marks(some)) {
    EXPECT_GE(mark.at.z, 28);
    const double rise = slope(some, mark.at);  // across 16 m; the generator's is across 24 m
    EXPECT_GT(rise, 0.05);
    EXPECT_LT(rise, 1.5);
    sum += rise;
  }
  const double mean = sum / static_cast<double>(marks(some).size());
  EXPECT_GT(mean, 0.364);  // of 20 degrees
  EXPECT_LT(mean, 0.839);  // of 40 degrees
  // Nothing is drained by less than its own cell.
  stated = scene();
  stated["operations"][0]["area"] = {{"high", 63}};
  EXPECT_EQ(marks(grown(stated)).size(), 0U);
  stated["operations"][0]["area"] = {{"high", 200}, {"falloff", 200}};
  const auto dry = marks(grown(stated)).size();
  EXPECT_GT(dry, marks(all).size() / 50);
  EXPECT_LT(dry, marks(all).size() * 9 / 10);
}

TEST_F(Hoodoos, GrowWithTheProbabilityThatIsStated) {
  auto stated = scene();
  const auto all = static_cast<double>(marks(grown(stated)).size());
  stated["operations"][0]["probability"] = 0.3;
  const auto some = static_cast<double>(marks(grown(stated)).size());
  EXPECT_NEAR(some, 0.3 * all, 3 * std::sqrt(all * 0.3 * 0.7));
}

TEST_F(Hoodoos, AreTheSameOnOneThreadAndOnTwo) {
  const auto one = grown(scene(), 1), two = grown(scene(), 2);
  EXPECT_EQ(one.ground.steps.at(0).tree, two.ground.steps.at(0).tree);
  EXPECT_EQ(one.grown.at(0).counts, two.grown.at(0).counts);
}

TEST_F(Hoodoos, AreOthersWithAnotherSeed) {
  auto stated = scene();
  const auto before = places(grown(stated));
  stated["operations"][0]["seed"] = 1;
  EXPECT_NE(places(grown(stated)), before);
  stated["operations"][0]["seed"] = 0;
  stated["seed"] = 3;
  EXPECT_NE(places(grown(stated)), before);
}

TEST_F(Hoodoos, OfARegionAreThoseOfEverywhereThatLieInIt) {
  auto stated = scene();
  const auto all = places(grown(stated));
  stated["operations"][0]["region"] = json::parse(
      R"({"type": "box", "min": [303, 211, -100], "max": [655, 540, 500], "feather": 0})");
  const auto some = places(grown(stated));
  std::set<std::pair<double, double>> inside;
  for (const auto& [x, y] : all) {
    if (x >= 303 && x <= 655 && y >= 211 && y <= 540) inside.insert({x, y});
  }
  ASSERT_GT(inside.size(), 100U);
  EXPECT_EQ(some, inside);
}

TEST_F(Hoodoos, LieFartherApartWhereTheyHardlySuit) {
  auto stated = scene();
  stated["operations"][0]["altitude"] = {{"low", 90}, {"falloff", 100}};
  const auto near = marks(grown(stated)).size();
  stated["operations"][0]["sparse_distance"] = 36;
  const auto made = grown(stated);
  EXPECT_LT(marks(made).size(), near);
  const auto& all = marks(made);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double apart = std::hypot(all[i].at.x - all[j].at.x, all[i].at.y - all[j].at.y);
      // Its chance is how well a place suits.
      const double least = 36 - 24 * (all[i].value + all[j].value) / 2;
      EXPECT_GE(apart, least - 1e-6);
    }
  }
}

TEST_F(Hoodoos, AreThinnerInWeakerLayers) {
  auto stated = scene();
  stated["geology"] = {{"type", "expression"}, {"formula", "smoothstep(-1, 1, z - 60)"}};
  stated["operations"][0]["grammar"] = json::parse(R"json({
    "axiom": "A",
    "rules": [{"symbol": "A", "to": [{"terminal": "layer", "move": [0, 0, 3]},
                                     {"terminal": "layer", "move": [0, 0, 9]}]}],
    "terminals": {"layer": {"type": "cylinder", "base": [0, 0, -5], "top": [0, 0, 5],
                            "radius": "1 + 2*rho"}}})json");
  stated["operations"][0]["smoothness"] = 0;
  const auto made = grown(stated);
  std::size_t weak = 0, hard = 0;
  for (const auto& body : children_of(made.ground.steps.at(0).tree)) {
    for (const auto& part : body.children) {
      const auto& layer = std::get<tree::Cylinder>(part.value);
      const double z = layer.base.value.z + 5;
      if (z < 59) {
        EXPECT_NEAR(layer.radius, 1, 1e-6);
        ++weak;
      }
      if (z > 61) {
        EXPECT_NEAR(layer.radius, 3, 1e-6);
        ++hard;
      }
    }
  }
  EXPECT_GT(weak, 100U);
  EXPECT_GT(hard, 100U);
}

TEST_F(Hoodoos, StandOnWhatEarlierOperationsLeft) {
  auto stated = scene();
  stated["operations"].insert(
      stated["operations"].begin(),
      json::parse(R"({"op": "union", "tree": {"type": "box", "center": [500, 500, 100],
                      "size": [200, 200, 120], "falloff": 4}})"));
  const auto made = grown(stated);
  std::size_t above = 0;
  for (const auto& mark : marks(made)) {
    const auto& p = mark.at;
    if (std::abs(p.x - 500) > 90 || std::abs(p.y - 500) > 90) continue;
    EXPECT_NEAR(p.z, 160, 0.5);
    ++above;
  }
  EXPECT_GT(above, 50U);
}

TEST_F(Hoodoos, GrowFromEveryPreset) {
  std::set<double> tallest;
  for (const auto* preset : {"hoodoo", "goblin", "rock_spire", "balanced_rock"}) {
    auto stated = scene();
    stated["operations"][0].update({{"preset", preset}, {"distance", 60}, {"variation", 0}});
    const auto made = grown(stated);
    EXPECT_EQ(count(made, "placed"), count(made, "sampled")) << preset;
    EXPECT_EQ(count(made, "symbols too deep"), 0U);
    EXPECT_EQ(count(made, "terminals without a size"), 0U);
    stated["operations"][0]["height"] = 30;
    const auto higher = grown(stated);
    const auto top = [](const Scene& s) {
      return tree::support(s.ground.steps[0].tree).influence.max.z;
    };
    EXPECT_GT(top(higher), top(made) + 5) << preset;
  }
}

TEST_F(Hoodoos, NameWhatIsWrong) {
  auto stated = scene();
  stated["operations"][0]["distance"] = -1;
  stated["operations"][0]["slope"] = {{"low", 50}, {"high", 120}};
  EXPECT_THAT(texts(problems(stated)),
              ElementsAre(AllOf(StartsWith("/operations/0/distance: "), HasSubstr("m")),
                          AllOf(StartsWith("/operations/0/slope/high: "), HasSubstr("deg"))));
  stated = scene();
  stated["operations"][0]["sparse_distance"] = 3;
  EXPECT_THAT(places_of(problems(stated)), ElementsAre("/operations/0/sparse_distance"));
  stated = scene();
  stated["operations"][0]["slope"] = {{"low", 50}, {"high", 20}};
  EXPECT_THAT(places_of(problems(stated)), ElementsAre("/operations/0/slope"));
  stated = scene();
  stated["operations"][0]["preset"] = "rock_spire";
  stated["operations"][0]["cap"] = 2;
  EXPECT_THAT(places_of(problems(stated)), ElementsAre("/operations/0/cap"));
  stated = scene();
  stated["operations"][0]["grammar"] =
      json::parse(R"({"axiom": "A", "rules": [{"symbol": "A", "to": ["rock"]}],
                                  "terminals": {"rock": {"use": "boulder"}}})");
  EXPECT_THAT(places_of(problems(stated)), ElementsAre("/operations/0/grammar/terminals/rock/use"));
  stated["define"]["boulder"] =
      json::parse(R"({"type": "sphere", "center": [0, 0, 0], "radius": 3})");
  EXPECT_TRUE(problems(stated).empty());
  EXPECT_GT(count(grown(stated), "placed"), 0U);
}

class Scattering : public Hoodoos {
 protected:
  static json scene() {
    auto made = minimal();
    made["operations"] = json::parse(R"([{"type": "scatter", "density": 0.002,
      "tree": {"type": "box", "center": [0, 0, 1], "size": [4, 3, 2], "falloff": 1}}])");
    return made;
  }
};

TEST_F(Scattering, HasTheDensityThatIsStated) {
  auto stated = scene();
  const auto made = grown(stated);
  EXPECT_NEAR(static_cast<double>(count(made, "placed")), 2000, 100);
  stated["operations"][0]["distance"] = 10;
  EXPECT_NEAR(static_cast<double>(count(grown(stated), "placed")), 2000, 150);
}

TEST_F(Scattering, TurnsScalesAndSinksItsCopies) {
  auto stated = scene();
  stated["operations"][0].update({{"align", "normal"},
                                  {"least_scale", 2},
                                  {"most_scale", 3},
                                  {"sink", 0.5},
                                  {"slope", {{"low", 15}}}});
  const auto made = grown(stated);
  const auto copies = children_of(made.ground.steps.at(0).tree);
  ASSERT_EQ(copies.size(), marks(made).size());
  for (std::size_t i = 0; i < copies.size(); ++i) {
    const auto& mark = marks(made)[i];
    EXPECT_GE(mark.value, 2);
    EXPECT_LE(mark.value, 3);
    const auto& moved = std::get<tree::Translate>(copies[i].value);
    EXPECT_NEAR(length(moved.by - mark.at), 0.5 * mark.value, 1e-6);
    // Up of the copy is away from the ground.
    Vec3 up{0, 0, 1};
    const auto& lean = std::get<tree::Rotate>(copies[i].children[0].value);
    up = lean.from_child(up);
    EXPECT_LT(length(mark.at - moved.by - up * (0.5 * mark.value)), 1e-6);
  }
}

TEST_F(Scattering, NamesWhatIsWrong) {
  auto stated = scene();
  stated["operations"][0].erase("tree");
  EXPECT_THAT(places_of(problems(stated)), ElementsAre("/operations/0/tree"));
  stated = scene();
  stated["operations"][0]["tree"] = {{"use", "nothing"}};
  EXPECT_THAT(places_of(problems(stated)), ElementsAre("/operations/0/tree/use"));
  stated = scene();
  stated["operations"][0]["tree"]["center"] = json::parse(R"({"xy": [1, 2], "ground": 0})");
  EXPECT_THAT(places_of(problems(stated)), ElementsAre("/operations/0/tree"));
  stated = scene();
  stated["operations"][0]["distance"] = 50;
  EXPECT_THAT(texts(problems(stated)),
              ElementsAre(AllOf(StartsWith("/operations/0/density: "), HasSubstr("1/m^2"))));
}

}  // namespace
}  // namespace hoodoo::scene
