#pragma once
#include <string>
#include <vector>

#include "engine/dem/dem.hpp"
#include "tests/bench/scene.hpp"

namespace hoodoo::bench {

/// The elevations of a scene, in memory, as a pyramid of one level.
class Table final : public dem::Pyramid {
 public:
  explicit Table(const Scene& scene);
  const std::vector<Level>& levels() const override { return levels_; }
  const std::string& name() const override { return name_; }
  const Digest& digest() const override { return digest_; }
  Box extent() const override { return extent_; }
  std::vector<Digest> chunks(int, const Box&) const override { return {digest_}; }
  dem::Window window(int, const Box& area) const override;
  std::optional<Interval> bounds(int, const Box& area) const override;

 private:
  const Scene& scene_;
  double corner_;  // of sample (0, 0), in x and y
  Box extent_;
  std::vector<Level> levels_;
  std::string name_ = "table";
  Digest digest_ = sha256("table");
};

}  // namespace hoodoo::bench
