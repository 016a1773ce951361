#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/base/box.hpp"

namespace hoodoo::tree {

/// One of many balls.
struct Ball {
  Vec3 center;
  double radius = 1;  // [m]
  float energy = 1;   // [1]
  friend bool operator==(const Ball&, const Ball&) = default;
};

/// An immutable list of balls that is asked by box; copies share it. Holds about 44 bytes per ball:
/// the balls along a space-filling curve, and boxes around each eight of them, each eight of
/// those, and so on.
class Balls {
 public:
  /// A ball and its place in the list.
  struct Stored {
    double x, y, z, radius;  // [m]
    float energy;
    std::uint32_t place;
    Ball ball() const { return {{x, y, z}, radius, energy}; }
  };
  /// A ball near a box, and how near and far the box's points can be from its centre [m].
  struct Found {
    const Stored* ball;
    double near, far;
  };

  Balls() = default;
  /// In the order in which they are summed up.
  explicit Balls(const std::vector<Ball>& list);

  std::size_t size() const { return data_ ? data_->balls.size() : 0; }
  bool empty() const { return size() == 0; }
  /// In their order.
  std::vector<Ball> list() const;
  /// Those whose radius, times `stretch`, plus `margin` [m], reaches `box`; in their order.
  std::vector<Found> near(const Box& box, double stretch, double margin) const;
  /// Around all of them, each ball's radius times `stretch`.
  Box box(double stretch) const;
  /// In no particular order.
  const std::vector<Stored>& stored() const;

  friend bool operator==(const Balls& a, const Balls& b);

 private:
  static constexpr std::size_t fan = 8;
  /// Around eight balls, or eight of the level below, each: their centres, rounded outward, and the
  /// largest of their radii, rounded up. Unused ones are empty.
  struct Groups {
    std::array<std::array<float, fan>, 3> low, high;
    std::array<float, fan> radius;
  };
  struct Data {
    std::vector<Stored> balls;
    std::vector<Groups> groups;       // level after level, each level eight by eight
    std::vector<std::size_t> levels;  // where each begins
  };
  struct Search;
  struct Builder;

  std::shared_ptr<const Data> data_;
};

}  // namespace hoodoo::tree
