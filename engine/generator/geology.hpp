#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "engine/generator/site.hpp"

namespace hoodoo::generator {

/// The resistance of a site's rock for many small questions: its geology, compiled block by block
/// as they are asked for, and kept. Blocks are anchored at the scene's origin, so that an answer
/// depends on the place alone. One thread at a time. Errors: cancelled.
class Geology {
 public:
  explicit Geology(const Site& site);
  void resistances(std::span<const Vec3> at, std::span<float> out);

 private:
  using Key = std::array<std::int64_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& key) const;
  };
  const tree::Field& block(const Key& key);

  const Site& site_;
  tree::Ground rock_;
  double side_;  // of a block [m]
  std::unordered_map<Key, std::unique_ptr<const tree::Field>, Hash> blocks_;
  Key last_key_{};
  const tree::Field* last_ = nullptr;
};

/// Heights of the input terrains for many small questions, read square by square and kept. The
/// first terrain that has one at a place wins. One thread at a time.
class Heights {
 public:
  explicit Heights(const Site& site);
  std::optional<double> at(double x, double y);

 private:
  using Key = std::array<std::int64_t, 2>;
  struct Hash {
    std::size_t operator()(const Key& key) const;
  };

  const Site& site_;
  double side_;  // of a square [m]
  std::unordered_map<Key, std::vector<dem::Window>, Hash> squares_;
};

}  // namespace hoodoo::generator
