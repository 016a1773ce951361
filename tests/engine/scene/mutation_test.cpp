#include <gtest/gtest.h>

#include "engine/base/json.hpp"
#include "engine/base/random.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

/// Every value of a document, deepest last.
void collect(json& at, std::vector<json*>& into) {
  into.push_back(&at);
  if (!at.is_structured()) return;
  for (auto& below : at) collect(below, into);
}

/// Changes one value of the scene to something else, or takes it away, or repeats it.
void mutate(json& scene, std::uint64_t bits) {
  std::vector<json*> values;
  collect(scene, values);
  json& victim = *values[random_bits(bits, 1) % values.size()];
  const json& other = *values[random_bits(bits, 2) % values.size()];
  static const std::vector<json> odd = {nullptr,
                                        true,
                                        -1,
                                        0,
                                        1e300,
                                        -1e-300,
                                        7.5,
                                        "",
                                        "use",
                                        json::array(),
                                        json::object(),
                                        "blend",
                                        1e308,
                                        4096,
                                        -7.,
                                        "hole",
                                        18446744073709551615ULL,
                                        {{"use", "ledge"}},
                                        {{"xy", {1, 2}}, {"ground", 3}},
                                        {{"uv", {0.5, 2}}, {"ground", 3}}};
  switch (random_bits(bits, 3) % 4) {
    case 0:
      victim = odd[random_bits(bits, 4) % odd.size()];
      break;
    case 1: {
      const json copy = other;
      victim = copy;
      break;
    }
    case 2:
      if (victim.is_object() && !victim.empty()) victim.erase(victim.begin());
      if (victim.is_array() && !victim.empty()) victim.erase(victim.size() - 1);
      break;
    default:
      if (victim.is_array() && !victim.empty()) {
        const json copy = victim.front();
        victim.push_back(copy);
      }
      if (victim.is_object()) {
        const json copy = other;
        victim["more"] = copy;
      }
  }
}

class Mutations : public SceneTest {};

TEST_F(Mutations, OfTheExampleEitherOpenOrNameTheirProblems) {
  const auto example = read(HOODOO_SCHEMA_DIR "/examples/first-light/scene.json");
  int good = 0, bad = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    SCOPED_TRACE(seed);
    auto scene = example;
    const auto changes = 1 + random_bits(seed, 0) % 3;
    for (std::uint64_t k = 0; k < changes; ++k) mutate(scene, random_bits(seed, 100 + k));
    const auto found = problems(scene);
    for (const auto& problem : found) {
      EXPECT_FALSE(problem.what.empty());
      EXPECT_TRUE(problem.where.empty() || problem.where[0] == '/') << problem.where;
    }
    if (!found.empty()) {
      ++bad;
      continue;
    }
    try {
      opened(scene);
      ++good;
    } catch (const Error& error) {
      EXPECT_NE(error.fault, Fault::internal) << error.what();
      ++bad;
    }
  }
  EXPECT_GT(good, 20);
  EXPECT_GT(bad, 200);
}

TEST_F(Mutations, OfTheTextEitherParseOrNameTheirProblems) {
  const auto text = read(HOODOO_SCHEMA_DIR "/examples/first-light/scene.json").dump();
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    SCOPED_TRACE(seed);
    auto broken = text;
    for (std::uint64_t k = 0; k < 1 + seed % 4; ++k) {
      const auto place = random_bits(seed, k, 0) % broken.size();
      switch (random_bits(seed, k, 1) % 3) {
        case 0:
          broken[place] = static_cast<char>(random_bits(seed, k, 2));
          break;
        case 1:
          broken.erase(place, 1 + random_bits(seed, k, 3) % 9);
          break;
        default:
          broken.insert(place, broken.substr(random_bits(seed, k, 4) % broken.size(), 12));
      }
    }
    try {
      problems(parse_json(broken, "scene"));
    } catch (const Error& error) {
      EXPECT_EQ(error.fault, Fault::bad_input) << error.what();
    }
  }
}

}  // namespace
}  // namespace hoodoo::scene
