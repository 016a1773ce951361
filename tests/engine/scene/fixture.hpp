#pragma once
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/scene/sample.hpp"
#include "engine/scene/scene.hpp"
#include "engine/tree/field.hpp"

namespace hoodoo::scene {

/// A folder of its own, gone at the end.
class Folder {
 public:
  Folder() {
    auto name = (std::filesystem::temp_directory_path() / "hoodoo-scene-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A folder with the sample DEM, coarse: 125 x 125 pixels of 8 m.
class SceneTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new Folder();
    write_sample_dem(*shared_ / "dem.tif", {125, 8, 1});
  }
  static void TearDownTestSuite() {
    delete shared_;
    shared_ = nullptr;
  }

  static Sources sources() { return {shared_->path(), {}}; }
  static const Folder& folder() { return *shared_; }
  /// The smallest scene.
  static nlohmann::json minimal() {
    return nlohmann::json::parse(
        R"({"hoodoo": 1, "terrains": [{"id": "land", "dem": "dem.tif"}]})");
  }
  static Scene opened(const nlohmann::json& scene) {
    return open(scene, sources(), {.cache = *shared_ / "cache", .ingest = {}});
  }
  static std::vector<Problem> problems(const nlohmann::json& scene) {
    return check(scene, sources());
  }

 private:
  static inline Folder* shared_ = nullptr;
};

/// A tree's children, also where they are packed.
inline std::vector<tree::Node> children_of(const tree::Node& tree) {
  std::vector<tree::Node> all;
  tree::for_each_child(tree, [&](const tree::Node& child) { all.push_back(child); });
  return all;
}

/// F of the scene at a point.
inline float field(const Scene& scene, const Vec3& p) {
  const Box box = Box{p, p}.grown(1);
  std::vector<dem::Window> windows;
  for (const auto& pyramid : scene.pyramids) windows.push_back(pyramid->window(0, box));
  const auto compiled = tree::compile(scene.ground, windows, p, box);
  const float zero[] = {0};
  float out[1];
  compiled->values({zero, zero, zero}, out);
  return out[0];
}

/// "where: what" of every problem.
inline std::vector<std::string> texts(const std::vector<Problem>& problems) {
  std::vector<std::string> list;
  for (const auto& problem : problems) list.push_back(problem.where + ": " + problem.what);
  return list;
}
/// The JSON Pointers alone, sorted.
inline std::vector<std::string> places_of(const std::vector<Problem>& problems) {
  std::vector<std::string> list;
  for (const auto& problem : problems) list.push_back(problem.where);
  std::sort(list.begin(), list.end());
  return list;
}

}  // namespace hoodoo::scene
