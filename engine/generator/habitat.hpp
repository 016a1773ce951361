#pragma once
#include <optional>
#include <tuple>
#include <vector>

#include "engine/generator/site.hpp"
#include "engine/tree/fields.hpp"

namespace hoodoo::generator {

/// 1 on [low, high], falling smoothly to 0 `falloff` beyond.
double within_range(double v, double low, double high, double falloff);

template <class R>
void check_rises(const R& range, const std::string& where, std::vector<Problem>& problems) {
  if (range.low > range.high) {
    problems.push_back({where, "\"low\" must be at most \"high\""});
  }
}

/// Slopes of the ground [deg].
struct SlopeRange {
  double low = 0, high = 90, falloff = 0;

  static constexpr auto fields() {
    using T = SlopeRange;
    using namespace tree;
    return std::tuple{Number<T>{"low", &T::low, "deg", within(0, 90), 0.0, "The least."},
                      Number<T>{"high", &T::high, "deg", within(0, 90), 90.0, "The greatest."},
                      Number<T>{"falloff", &T::falloff, "deg", within(0, 90), 0.0,
                                "How far beyond both the probability falls to 0."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    check_rises(*this, where, problems);
  }
  bool everywhere() const { return low == 0 && high == 90; }
};

/// Drainage areas [m^2].
struct AreaRange {
  static constexpr double all = 1e15;
  double low = 0, high = all, falloff = 0;

  static constexpr auto fields() {
    using T = AreaRange;
    using namespace tree;
    return std::tuple{Number<T>{"low", &T::low, "m^2", within(0, all), 0.0, "The least."},
                      Number<T>{"high", &T::high, "m^2", within(0, all), all, "The greatest."},
                      Number<T>{"falloff", &T::falloff, "m^2", within(0, all), 0.0,
                                "How far beyond both the probability falls to 0."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    check_rises(*this, where, problems);
  }
  bool everywhere() const { return low == 0 && high == all; }
};

/// Elevations of the ground [m].
struct AltitudeRange {
  double low = -tree::farthest, high = tree::farthest, falloff = 0;

  static constexpr auto fields() {
    using T = AltitudeRange;
    using namespace tree;
    return std::tuple{
        Number<T>{"low", &T::low, "m", within(-farthest, farthest), -farthest, "The least."},
        Number<T>{"high", &T::high, "m", within(-farthest, farthest), farthest, "The greatest."},
        Number<T>{"falloff", &T::falloff, "m", within(0, farthest), 0.0,
                  "How far beyond both the probability falls to 0."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    check_rises(*this, where, problems);
  }
};

/// Where something likes to grow.
struct Habitat {
  SlopeRange slope;
  AreaRange area;
  AltitudeRange altitude;
  std::optional<double> cell;  // [m]
};

template <class G>
constexpr auto habitat_fields() {
  using namespace tree;
  return std::tuple{
      Group<G, SlopeRange>{"slope", &G::slope, "Slopes of the ground where it may stand."},
      Group<G, AreaRange>{"area", &G::area,
                          "Areas that drain through a place where it may stand; of the whole "
                          "world's input terrain."},
      Group<G, AltitudeRange>{"altitude", &G::altitude,
                              "Elevations of the ground where it may stand."},
      OptionalNumber<G>{"cell", &G::cell, "m", above(0, longest),
                        "Side of the cells by which slope and area are found; by default a "
                        "pixel of the terrain."}};
}

/// A habitat on the input terrain of a site.
class HabitatMap {
 public:
  /// For places in `box` (x and y). Errors: limit, where the cells take more than the memory.
  HabitatMap(const Site& site, const Habitat& habitat, const Box& box);

  /// In [0, 1]; 0 where there is no ground.
  double suitability(double x, double y) const;

 private:
  const Habitat& habitat_;
  Elevations ground_;
  std::vector<float> slope_, area_;  // area_ is empty where all are welcome
};

/// A place on the ground.
struct Footing {
  Vec3 at;       // [m]
  Vec3 normal;   // of the input terrain, upward
  double slope;  // rise over run
  bool found = false;
};

/// Finds the ground at places (z is not looked at): the input terrain's, or, where a step of the
/// scene so far reaches it, the surface next to that. Not found: no terrain, or no such surface.
std::vector<Footing> footings(const Site& site, const std::vector<Vec3>& at);

}  // namespace hoodoo::generator
