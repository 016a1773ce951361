#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/hash.hpp"

namespace hoodoo::tree {

/// One of many balls.
struct Ball {
  Vec3 center;
  double radius = 1;  // [m]
  float energy = 1;   // [1]
  friend bool operator==(const Ball&, const Ball&) = default;
};

/// Names a list of balls, fed one by one.
class BallDigest {
 public:
  void add(const Ball& ball);
  Digest finish() { return hash_.finish(); }

 private:
  Sha256 hash_;
};

class BallFile;  // ball_file.hpp

/// An immutable list of balls that is asked by box; copies share it. Holds about 44 bytes per ball:
/// the balls along a space-filling curve, and boxes around each eight of them, each eight of
/// those, and so on. Or it lies in a file, of which `part` takes what is wanted into memory.
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

  explicit Balls(std::shared_ptr<const BallFile> file) : file_(std::move(file)) {}

  std::size_t size() const;
  bool in_file() const { return file_ != nullptr; }
  bool empty() const { return size() == 0; }
  /// In their order.
  std::vector<Ball> list() const;
  /// Names the list, wherever it lies.
  Digest digest() const;
  /// In memory: of these at least those that `near` finds and whose radius is at least `least`;
  /// all of them where they are in memory already. Errors: io.
  Balls part(const Box& box, double stretch, double margin, double least = 0) const;
  /// Those whose radius, times `stretch`, plus `margin` [m], reaches `box`; in their order.
  /// Of balls in memory.
  std::vector<Found> near(const Box& box, double stretch, double margin) const;
  /// Around all of them, each ball's radius times `stretch`.
  Box box(double stretch) const;
  /// In no particular order. Errors: io.
  void for_each(const std::function<void(const Stored&)>& visit) const;

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
  std::shared_ptr<const BallFile> file_;
};

}  // namespace hoodoo::tree
